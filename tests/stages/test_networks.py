"""`foggy networks` states what the networks cost."""

import json

from foggy_synscapes.cli import main


def test_json_has_one_object_per_network_at_its_published_size(capsys):
    assert main(["networks", "--json"]) == 0
    found = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)}
    assert found["refinenet"]["backbone"] == "resnet101"
    assert found["refinenet"]["parameters"] == 118_047_827
    assert found["bisenet"]["backbone"] == "resnet18"
    assert found["bisenet"]["parameters"] == 13_494_777
    assert round(found["refinenet"]["multiply_adds_1024x512"] / 1e9, 1) == 525.6


def test_lines_for_people_name_both(capsys):
    assert main(["networks"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["refinenet", "bisenet"]
