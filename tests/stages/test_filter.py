"""filter: rules on metadata decide, and broken metadata is named."""

import json
from pathlib import Path

import pytest
from records import index_of, vouch

from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.datasets.synscapes import SCENE_KEYS
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages.filter import filter

ROOT = Path(__file__).resolve().parents[2]
INTRINSIC = {"fx": 1590.8, "fy": 1592.7, "u0": 771.3, "v0": 360.8, "resx": 1440, "resy": 720}


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    """Three frames with sky_contrast 2, 3 and 6 in a folder whose name has spaces and quotes."""
    monkeypatch.chdir(tmp_path)
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"]["synscapes"] = str(tmp_path / 'it\'s a "root"')
    document["scenes"]["shards"] = ["0000"]
    for frame, contrast in ((1, 2.0), (2, 3.0), (3, 6.0)):
        write_meta(tmp_path, frame, sky_contrast=contrast)
    return check(document, "params.yaml")


def write_meta(folder: Path, frame: int, **scene: object) -> None:
    path = folder / 'it\'s a "root"' / f"meta/{frame}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    values = dict.fromkeys(SCENE_KEYS, 0.5) | scene
    document = {"camera": {"intrinsic": INTRINSIC}, "scene": values, "instance": {}, "unknown": 1}
    path.write_text(json.dumps(document))


def listed(params: Params) -> None:
    root = Path(params.scenes.roots["synscapes"])
    write_index(index_of("synscapes", "0000"), root, [f"meta/{path.name}" for path in (root / "meta").iterdir()])
    vouch()


def test_a_frame_is_kept_if_every_rule_holds(params: Params) -> None:
    listed(params)
    filter(params)
    frames = read_csv("results/filter/frames.csv")
    assert [(row["id"], row["kept"], row["reason"]) for row in frames] == [
        ("1", "1", ""),
        ("2", "1", ""),
        ("3", "0", "sky_contrast 6 above 5"),
    ]
    assert set(SCENE_KEYS) <= frames[0].keys()
    kept = read_csv("results/filter/kept.csv")
    assert [row["id"] for row in kept] == ["1", "2"]
    assert float(kept[0]["fx"]) == INTRINSIC["fx"]


def test_the_record_names_no_folder_of_the_machine(params: Params, tmp_path: Path) -> None:
    listed(params)
    filter(params)
    assert str(tmp_path) not in Path("results/filter/run.json").read_text()


def test_a_value_that_is_missing_ends_no_run_and_is_counted(params: Params, tmp_path: Path, capsys) -> None:
    """Keys that no rule uses do not matter; a frame without the one that a rule uses is left out, with the reason."""
    write_meta(tmp_path, 1, fence_presence=True, ego_speed=None, more="x")
    write_meta(tmp_path, 2, sky_contrast=float("nan"))
    path = tmp_path / 'it\'s a "root"' / "meta/2.json"
    document = json.loads(path.read_text())
    del document["scene"]["ego_speed"]
    path.write_text(json.dumps(document))
    listed(params)
    filter(params)
    rows = {row["id"]: row for row in read_csv("results/filter/frames.csv")}
    assert (rows["1"]["kept"], rows["1"]["fence_presence"], rows["1"]["ego_speed"]) == ("1", "1", "nan")
    assert (rows["2"]["kept"], rows["2"]["reason"]) == ("0", "sky_contrast nan above 5")
    told = capsys.readouterr().out
    assert "ego_speed is missing, or no number, in the meta files of 2 frames" in told
    assert "sky_contrast is missing, or no number, in the meta files of 1 frames" in told


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not a readable JSON file"),
        ("[]", "expected an object with `camera`"),
        ('{"camera": {"intrinsic": {}}}', "no section `scene`"),
    ],
)
def test_a_broken_meta_file_is_named(params: Params, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / 'it\'s a "root"' / "meta/1.json").write_text(text)
    listed(params)
    with pytest.raises(FoggyError, match=message):
        filter(params)


def test_a_camera_without_focal_length_is_named(params: Params, tmp_path: Path) -> None:
    path = tmp_path / 'it\'s a "root"' / "meta/1.json"
    document = json.loads(path.read_text())
    del document["camera"]["intrinsic"]["fy"]
    path.write_text(json.dumps(document))
    listed(params)
    with pytest.raises(FoggyError, match=r"camera\.intrinsic\.fy missing"):
        filter(params)


def test_a_meta_file_that_changed_since_it_was_listed_is_refused(params: Params, tmp_path: Path) -> None:
    listed(params)
    write_meta(tmp_path, 1, sky_contrast=4.0)
    with pytest.raises(FoggyError, match="changed since it was listed"):
        filter(params)


def test_rules_that_keep_nothing_or_name_no_key_are_errors(params: Params) -> None:
    listed(params)
    document = params.model_dump(by_alias=True)
    document["filter"]["rules"] = [{"key": "sky_contrast", "maximum": 1.0}]
    with pytest.raises(FoggyError, match="none of 3 frames is left"):
        filter(check(document, "params.yaml"))
    document["filter"]["rules"] = [{"key": "sky_contrst", "maximum": 1.0}]
    with pytest.raises(FoggyError, match="did you mean sky_contrast"):
        filter(check(document, "params.yaml"))
