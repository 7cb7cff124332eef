"""A dataset, a test set, a figure and a kind of row are each one module: nothing else has to know its name."""

import inspect
from pathlib import Path

import numpy as np
import pytest
from records import index_of

from foggy_synscapes import datasets
from foggy_synscapes.cli import main
from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.figures import FIGURES
from foggy_synscapes.figures.figure import INPUTS, Figure
from foggy_synscapes.figures.sources import Sources
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.params import check, load
from foggy_synscapes.registry import use_plugins
from foggy_synscapes.results import roots
from foggy_synscapes.stages.figures import figures
from foggy_synscapes.stages.scenes import scenes
from foggy_synscapes.stages.subset import subset
from foggy_synscapes.standin.layouts import STAND_INS
from foggy_synscapes.steps import job
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import IMAGES

ROOT = Path(__file__).resolve().parents[2]

MIST = """
from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.schema import Count
from foggy_synscapes.standin.layouts.layout import Frame, StandIn
from foggy_synscapes.subsets.kind import Kind, Row
from foggy_synscapes.figures.figure import Figure


def files(root, scenes, part):
    return [path.relative_to(root).as_posix() for path in root.glob("*.png")]


def tested(root, index, scenes):
    return [(path, path.replace("image", "label")) for path in sorted(index) if path.startswith("image")]


DATASET = Dataset(title="Mist, test", short_title="Mist", files=files, test_pairs=tested)


def lists(sources, entry, key):
    index = sources.index("mist")
    lines = [(f"mist:{i}", index[i], f"mist:{l}", index[l]) for i, l in tested(None, index, None)]
    return lines[: entry.train], lines[entry.train :]


KIND = Kind(text="Mist", entry=Row, reads=("mist",), lists=lists)


def draw(sources):
    from foggy_synscapes.figures.panels import grid

    return grid([[sample.rgb for sample in sources.images(2)]], ["a", "b"], title=sources.title())


FIGURE = Figure(text="Mist.", inputs=("images",), draw=draw, of_test_set=True)
"""
DRAWN = """

def render():
    import numpy as np

    return [np.zeros((4, 4, 3), np.uint8)]


def frames(plan):
    return [Frame(["image_0.png"], render, ())] * plan.mist


STAND_IN = StandIn(counts=Count, text="Mist.", published="2", frames=frames)
"""


@pytest.fixture
def document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict:
    """Params with a dataset of a plugin: two images and their label maps."""
    monkeypatch.chdir(tmp_path)
    write_text(tmp_path / "plugins/mist.py", MIST)
    for number in range(2):
        write_bytes(tmp_path / f"mist/image_{number}.png", encode_png(np.full((8, 16, 3), number, np.uint8)))
        write_bytes(tmp_path / f"mist/label_{number}.png", encode_png(np.full((8, 16), 21, np.uint8)))
    document = read_yaml(ROOT / "params.yaml")
    document["plugins"] = str(tmp_path / "plugins")
    document["scenes"]["roots"]["mist"] = str(tmp_path / "mist")
    document["evaluate"]["test_sets"].append("mist")
    document["subset"]["mist"] = {"M": {"train": 1, "validation": 1}}
    document["train"]["from_baseline"].append("M")
    document["train"]["rows"]["M"] = document["train"]["rows"]["FC-498"]
    yield document
    use_plugins(None)


def test_a_module_adds_a_dataset_that_is_listed_drawn_and_trained_on(document: dict) -> None:
    params = check(document, "params.yaml")
    assert "mist" in datasets.test_sets()
    scenes(params, "mist")
    assert list(read_index(index_of("mist"))) == ["image_0.png", "image_1.png", "label_0.png", "label_1.png"]
    subset(params, "M")
    assert "mist:image_0.png" in Path("results/subset/M/train.csv").read_text()
    drawn = job(params, "figures_mist", test_set="mist")
    assert drawn.command == ["foggy", "figures", "--figure", "mist_mist"]
    figures(params, "mist_mist")
    assert Path("results/figures/mist_mist.png").is_file()
    assert Sources(drawn, roots(params)).title() == "Mist (stand-in)"


def test_a_dataset_without_a_stand_in_needs_a_folder(document: dict) -> None:
    document["scenes"]["roots"]["mist"] = "stand-in"
    with pytest.raises(FoggyError, match=r"scenes\.roots: mist: has no stand-in; name the folder"):
        check(document, "params.yaml")


def test_a_module_adds_a_stand_in_whose_count_stands_in_the_params(document: dict) -> None:
    write_text("plugins/mist.py", MIST + DRAWN)
    del document["scenes"]["roots"]["mist"]
    with pytest.raises(FoggyError, match=r"scenes\.roots: mist missing, which evaluate, tradeoff or subset needs"):
        check(document, "params.yaml")
    document["scenes"]["roots"]["mist"] = "stand-in"
    with pytest.raises(FoggyError, match=r"stand_in\.mist: missing\. Say how many frames of mist are rendered"):
        check(document, "params.yaml")
    document["scenes"]["stand_in"]["mist"] = 1
    params = check(document, "params.yaml")
    assert job(params, "scenes_mist").keys()[-1] == "scenes.stand_in.mist"
    scenes(params, "mist")
    assert list(read_index(index_of("mist"))) == ["image_0.png"]


def test_what_is_trained_or_tested_on_needs_a_root_and_other_datasets_do_not(document: dict) -> None:
    del document["scenes"]["roots"]["mist"]
    missing = r"scenes\.roots: mist missing, which evaluate, tradeoff or subset needs"
    with pytest.raises(FoggyError, match=missing):
        check(document, "params.yaml")
    document["evaluate"]["test_sets"].remove("mist")
    with pytest.raises(FoggyError, match=missing):
        check(document, "params.yaml")
    del document["subset"]["mist"], document["train"]["rows"]["M"]
    document["train"]["from_baseline"].remove("M")
    with pytest.raises(FoggyError, match=r"scenes\.roots\.mist: missing"):
        scenes(check(document, "params.yaml"), "mist")


@pytest.mark.parametrize(
    ("section", "key", "value", "message"),
    [
        (
            "roots",
            "rain",
            "stand-in",
            "'rain' is no dataset; there are cityscapes, cityscapes_stereo, foggy_",
        ),
        ("stand_in", "rain", 3, "scenes.stand_in.rain: unknown key"),
        ("stand_in", "foggy_driving", {"fin": 1}, "scenes.stand_in.foggy_driving.fin: unknown key; did you mean fine"),
        ("stand_in", "foggy_driving", 4, "scenes.stand_in.foggy_driving: "),
    ],
)
def test_a_wrong_name_or_count_of_a_dataset_is_named(section: str, key: str, value: object, message: str) -> None:
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"][section][key] = value
    with pytest.raises(FoggyError) as caught:
        check(document, "params.yaml")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "entry", "message"),
    [
        ("rainy", {}, "subset.rainy: unknown key"),
        ("clear", {"C": {"train": 400}}, "subset.clear.C.validation: missing"),
        ("partial", {"FC-498": {"beta": "0.010", "train": 1, "validation": 1}}, "subset.partial.FC-498.beta: beta"),
    ],
)
def test_a_wrong_list_is_named_by_its_key(kind: str, entry: dict, message: str) -> None:
    document = read_yaml(ROOT / "params.yaml")
    document["subset"][kind] = entry
    with pytest.raises(FoggyError) as caught:
        check(document, "params.yaml")
    assert message in str(caught.value)


def test_a_kind_that_the_params_leave_out_has_no_rows() -> None:
    document = read_yaml(ROOT / "params.yaml")
    document["subset"]["mixed"] = {}
    document["train"]["from_baseline"].remove("FC-FS-498")
    del document["train"]["rows"]["FC-FS-498"]
    document["tradeoff"]["row"] = "C"
    assert check(document, "params.yaml").subset.kinds()["mixed"] == {}


def test_a_test_set_or_figure_that_is_none_is_a_wrong_call(capsys: pytest.CaptureFixture) -> None:
    params = ["--params", str(ROOT / "params.yaml")]
    job = ["--network", "bisenet", "--row", "C", "--seed", "0"]
    for call in (["evaluate", *job], ["tables"], ["trace", "--cell", "bisenet", "C", "sky"]):
        assert main([*call, "--test-set", "synscapes", *params]) == 2
        assert "--test-set synscapes: there are cityscapes, foggy_driving, foggy_zurich" in capsys.readouterr().err
    assert main(["scenes", "--dataset", "rain", *params]) == 2
    assert "--dataset rain: scenes.roots has synscapes, cityscapes" in capsys.readouterr().err
    with pytest.raises(UsageError, match="--figure confusion: there are beta_strip, class_change_foggy_driving, "):
        figures(load(ROOT / "params.yaml"), "confusion")


def test_declarations_name_what_there_is() -> None:
    params = load(ROOT / "params.yaml")
    document = params.model_dump(by_alias=True)
    for name in DATASETS:
        assert all(
            len(key.split(".")) == 2 and key.split(".")[1] in document["scenes"] for key in DATASETS[name].settings
        )
    for name in STAND_INS:
        assert name in DATASETS
        assert set(STAND_INS[name].others) <= set(STAND_INS)
    for name in KINDS:
        assert set(KINDS[name].reads) <= {*IMAGES, *DATASETS}
    methods = dict(inspect.getmembers(Sources, inspect.isfunction))
    assert set(INPUTS) <= methods.keys()
    assert {name for figure in FIGURES for name in FIGURES[figure].inputs} == set(INPUTS)


def test_a_figure_of_unknown_inputs_or_without_a_test_set_is_refused() -> None:
    with pytest.raises(ValueError, match="inputs: rain unknown; there are frames"):
        Figure(text="", inputs=("rain",), draw=print)
    for name in ("metrics", "predictions", "images"):
        with pytest.raises(ValueError, match=f"inputs: {name} .*of_test_set"):
            Figure(text="", inputs=("frames", name), draw=print)
