"""A folder of plugins, one of each kind, goes through both engines; docs/extending.md shows its code."""

import re
from pathlib import Path

import numpy as np
import pytest
import warm
from changes import Change, Edit, changed
from engines import ROOT, clone, for_dvc, hashes, own_sources, planned, run

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.figures import FIGURES
from foggy_synscapes.fog.geometry import straight
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import check, load, resolved
from foggy_synscapes.registry import use_plugins
from foggy_synscapes.stages.steps import dvc_yaml
from foggy_synscapes.steps import REGISTRIES, steps

EXAMPLE = "examples/plugins.yaml"
FIGURE = "results/figures/frame_depths.png"
PREDICTIONS = "results/figures/predictions_toy_street.png"
TABLE = "results/tables/toy_street.csv"
ADDED = {"datasets": "toy_street", "stand_ins": "toy_street", "networks": "tiny_net", "fog_models": "linear_fog"}
ADDED |= {"figures": "frame_depths", "subsets": "refined_and_clear"}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """By engine, a clone in which it made the table and figures of what the plugins add."""
    folders = {name: clone(tmp_path_factory.mktemp(f"plugins by {name}")) for name in ("snakemake", "dvc")}
    with warm.jobs(tmp_path_factory.mktemp("warm") / "jobs", {}) as changes:
        figures = (FIGURE, PREDICTIONS)
        targets = (TABLE, *figures, "--cores", "1", "--configfile", EXAMPLE)
        run(folders["snakemake"], "snakemake", *targets, changes=changes)
        folder = for_dvc(folders["dvc"], EXAMPLE)
        run(folder, "foggy_synscapes", "steps", "--dvc", "dvc.yaml", changes=own_sources(folder))
        run(folder, "dvc", "repro", "tables", "figures_frame_depths", changes=changes)
    return folders


@pytest.fixture
def plugins():
    """The folder of the example, in use."""
    use_plugins(ROOT / "examples/plugins")
    yield
    use_plugins(None)


def test_what_plugins_add_is_in_tables_and_figures(made: dict[str, Path]) -> None:
    folder = made["snakemake"]
    lines = read_csv(folder / TABLE)
    assert {(line["network"], line["row"]) for line in lines} == {("TinyNet", row) for row in ("C", "FS", "FC-and-C")}
    scored = {line["row"] for line in lines if line["score"] == "road" and line["seed_0"] not in ("-", "--")}
    assert scored == {"C", "FS", "FC-and-C"}
    for name in (FIGURE, PREDICTIONS):
        assert (folder / name).is_file()
        assert (folder / name).with_suffix(".pdf").is_file()
    images = [line["image"].partition(":")[0] for line in read_csv(folder / "results/subset/FC-and-C/train.csv")]
    assert images == ["foggy_cityscapes", "cityscapes"] * 2
    record = (folder / "results/fog/beta_0.005/0000.run.json").read_text()
    assert '"foggy_plugins.linear_fog"' in record


def test_both_engines_make_the_same_of_plugins(made: dict[str, Path]) -> None:
    ours, theirs = hashes(made["snakemake"]), hashes(made["dvc"])
    both = [name for name in theirs if not name.startswith("results/code/")]
    assert {TABLE, FIGURE} <= {*both}
    assert {name: ours.get(name) for name in both} == {name: theirs[name] for name in both}


def test_naming_a_folder_of_plugins_runs_only_what_they_add(snakemake: Path, tmp_path: Path) -> None:
    change = Change("plugins", (Edit("params/smoke.yaml", new="\nplugins: examples/plugins\n"),))
    with changed(snakemake, change, tmp_path):
        assert set(planned(snakemake)) == {"figures frame_depths"}


def test_every_kind_of_entry_has_an_example(plugins: None) -> None:
    # Layouts are of commands without params, which know no folder of plugins.
    assert set(ADDED) == set(REGISTRIES) - {"layouts"}
    for registry, name in ADDED.items():
        assert REGISTRIES[registry][name] is not None
    assert (DATASETS["toy_street"].title, FIGURES["frame_depths"].of_test_set) == ("Toy Street", False)


def test_params_that_ask_for_no_entry_of_a_folder_are_good_and_have_no_job_of_its_test_set() -> None:
    params = check({"plugins": str(ROOT / "examples/plugins")}, "params.yaml")
    (step,) = [step for step in steps() if step.name == "scenes_toy_street"]
    assert step.all_values(params) == []
    assert "toy_street" not in dvc_yaml(params)
    use_plugins(None)


def test_a_stand_in_without_a_count_is_named() -> None:
    stated = {"plugins": str(ROOT / "examples/plugins"), "scenes": {"roots": {"toy_street": "stand-in"}}}
    with pytest.raises(FoggyError, match=r"stand_in\.toy_street: missing\. Say how many frames"):
        check(stated, "params.yaml")
    use_plugins(None)


def test_a_complete_file_keeps_kinds_without_rows_empty(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    params = load(EXAMPLE)
    (tmp_path / "params.yaml").write_text(resolved.text(params))
    assert load(tmp_path / "params.yaml") == params
    assert params.subset.kinds()["mixed"] == {}
    use_plugins(None)


def test_the_toy_fog_falls_linearly_to_nothing(plugins: None) -> None:
    model, beta = MODELS["linear_fog"], 0.02996  # visibility 100 m
    depth = np.array([[0.0, 50.0, 100.0, np.inf]], np.float32)
    rays = straight(depth.shape)
    assert model.transmittances(depth, rays, [beta, 0.0]).tolist() == [[[255, 128, 0, 0]], [[255] * 4]]
    image = np.full((1, 4, 3), 100, np.uint8)
    assert model.images(image, depth, rays, (200, 200, 200), [beta])[0, 0, :, 0].tolist() == [100, 150, 200, 200]


def test_no_file_of_the_project_knows_a_plugin() -> None:
    names = re.compile("|".join(ADDED.values()))
    for folder in ("src", "workflow"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".smk", ".yaml", ".rst"):
                assert not names.search(path.read_text(encoding="utf-8")), path


def test_the_page_on_extending_shows_the_files_as_they_are() -> None:
    page = (ROOT / "docs/extending.md").read_text(encoding="utf-8")
    code = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples/plugins").glob("*.py"))]
    sources = {"python": code, "yaml": [(ROOT / EXAMPLE).read_text(encoding="utf-8")]}
    shown = re.findall(r"```(python|yaml)\n(.*?)```", page, re.DOTALL)
    assert len(shown) > 10
    for language, text in shown:
        assert any(text in source for source in sources[language]), text
