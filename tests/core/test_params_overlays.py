"""Overlays: what a params file leaves out comes from the packaged defaults, and what it comes to is printed whole."""

import json
from pathlib import Path

import pytest
import yaml

from foggy_synscapes import params
from foggy_synscapes.cli import main
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.params import reference, resolved
from foggy_synscapes.params.sources import KNOWN
from foggy_synscapes.registry import Registry

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ["params.yaml", "params/smoke.yaml", "params/paper.yaml", "params/discussion.yaml"]
SHIPPED += ["params/refinenet_as_printed.yaml", "params/discussion_full.yaml", "params/refinenet_baseline.yaml"]
DEFAULTS = params.check({}, "defaults")


def overlaid(overlay: dict) -> dict:
    return params.check(overlay, "params.yaml").model_dump(mode="json", by_alias=True)


def test_sections_are_merged_key_by_key() -> None:
    changed = overlaid({"train": {"bisenet": {"baseline": {"batch": 8}}}})
    expected = DEFAULTS.model_dump(mode="json", by_alias=True)
    expected["train"]["bisenet"]["baseline"]["batch"] = 8
    assert changed == expected


def test_lists_are_replaced_whole() -> None:
    assert overlaid({"filter": {"rules": []}})["filter"]["rules"] == []
    assert overlaid({"evaluate": {"test_sets": ["foggy_zurich"]}})["evaluate"]["test_sets"] == ["foggy_zurich"]


def test_a_length_in_epochs_replaces_one_in_iterations() -> None:
    changed = overlaid({"train": {"bisenet": {"baseline": {"length": {"epochs": 2}}}}})
    assert changed["train"]["bisenet"]["baseline"]["length"] == {"images": None, "epochs": 2, "iterations": None}


def test_rows_that_the_user_names_are_replaced_whole() -> None:
    overlay = {
        "fog": {"frames": {"first": 5}},
        "subset": {"pure": {"mine": {"beta": "0.005", "train": 5, "validation": 60}}, "partial": {}, "mixed": {}},
        "train": {"from_baseline": ["mine", "C-control"], "rows": {"C": None}},
        "tradeoff": {"row": "C"},
    }
    span = {"length": {"epochs": 1}, "validate": {"epochs": 1}}
    overlay["train"]["rows"] |= {"mine": span, "C-control": span}
    assert list(params.check(overlay, "params.yaml").subset.rows()) == ["C", "C-control", "mine"]


def test_null_stands_for_itself_not_for_the_default() -> None:
    start = {"weights": "start.safetensors", "baseline": None}
    assert overlaid({"train": {"bisenet": start}})["train"]["bisenet"]["baseline"] is None
    with pytest.raises(FoggyError, match="fog: "):
        params.check({"fog": None}, "params.yaml")


def test_the_defaults_are_not_those_of_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("params.yaml").write_text("figures: {images: 7}")
    Path("mine.yaml").write_text("{}")
    assert params.load("mine.yaml") == DEFAULTS


@pytest.mark.parametrize("name", SHIPPED)
def test_what_is_printed_asks_for_the_same(name: str, tmp_path: Path) -> None:
    whole = params.load(ROOT / name)
    path = tmp_path / "params.yaml"
    path.write_text(resolved.text(whole))
    assert params.load(path) == whole
    assert resolved.text(params.load(path)) == path.read_text()
    assert max(map(len, path.read_text().splitlines())) <= resolved.WIDTH
    params.require_complete(path)


@pytest.mark.parametrize(
    "word", ["yes", "null", "1e3", "5e-5", "a: b", "x # y", 'it\'s "so"', "C (control)", "\x7f\u2028"]
)
def test_any_word_and_any_number_is_read_back_as_it_was(word: str) -> None:
    value = {"word": word, "list": [word, 5e-5, 1e20, 3, None, True], word: []}
    assert yaml.safe_load(resolved.flow(value)) == value


def test_the_working_params_are_those_of_an_empty_overlay(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / "empty.yaml"
    path.write_text("{}")
    assert main(["params", "--file", str(path)]) == 0
    assert capsys.readouterr().out == (ROOT / "params.yaml").read_text()


def test_an_overlay_is_written_complete_for_dvc(tmp_path: Path) -> None:
    out = tmp_path / "params.yaml"
    assert main(["params", "--file", str(ROOT / "params/smoke.yaml"), "--out", str(out)]) == 0
    params.require_complete(out)
    assert params.load(out) == params.load(ROOT / "params/smoke.yaml")


def test_an_overlay_in_the_place_of_dvcs_params_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text("train: {threads: 2}")
    with pytest.raises(FoggyError, match=r"leaves plugins to the packaged defaults .* foggy params --file .* --out"):
        params.require_complete(path)


def test_a_check_prints_nothing_but_that_the_file_is_good(capsys: pytest.CaptureFixture) -> None:
    path = ROOT / "params/smoke.yaml"
    assert main(["params", "--file", str(path), "--check"]) == 0
    assert capsys.readouterr().out == f"{path}: good\n"


def test_the_published_schema_and_page_are_those_of_the_code() -> None:
    made = "run foggy params --{} --out docs/{}"
    name = "params.schema.json"
    assert (ROOT / "docs" / name).read_text() == reference.json_schema(), made.format("schema", name)
    page = reference.markdown(resolved.document(DEFAULTS))
    assert (ROOT / "docs/parameters.md").read_text() == page, made.format("docs", "parameters.md")


def test_the_schema_lets_an_overlay_leave_out_what_it_does_not_change() -> None:
    schema = json.loads(reference.json_schema())
    assert "required" not in schema
    assert "required" not in schema["$defs"]["Fog"]
    assert schema["$defs"]["FoggyRow"]["required"] == ["train", "validation", "beta"]
    assert schema["$defs"]["Fog"]["additionalProperties"] is False


def test_every_key_says_what_it_means() -> None:
    document = resolved.document(DEFAULTS)
    for top in (
        "scenes",
        "filter",
        "fog",
        "subset",
        "train",
        "evaluate",
        "tables",
        "figures",
        "view",
        "stability",
        "tradeoff",
    ):
        section = reference.section_in(params.Params.model_fields[top].annotation)
        for key in reference.keys(section, top, document):
            assert key.field.description, key.name


def test_what_is_known_of_a_value_is_known_of_a_key_that_there_is() -> None:
    texts = [resolved.document(params.load(ROOT / name)) for name in SHIPPED]
    for key in KNOWN:
        assert any(list(reference.found(document, key)) for document in texts), key


def test_plugins_are_found_from_the_moment_that_params_name_them(tmp_path: Path) -> None:
    (tmp_path / "my_network.py").write_text("NETWORK = 1\n")
    networks = Registry("networks", "NETWORK", "network")
    params.check({"plugins": str(tmp_path)}, "params.yaml")
    assert "my_network" in networks
    params.check({}, "params.yaml")
    assert "my_network" not in networks
