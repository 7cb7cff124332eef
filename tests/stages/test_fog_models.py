"""`foggy fog --model`, and rows of the experiment by a fog model of their own."""

import json
from pathlib import Path

import numpy as np
import pytest
from fog_frames import CAMERA, content, write_frames

from foggy_synscapes import params
from foggy_synscapes.cli import main
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog import models
from foggy_synscapes.frames.rendering import NOTE
from foggy_synscapes.io.images import is_whole_png, read_rgb
from foggy_synscapes.io.png_text import note
from foggy_synscapes.steps import all_jobs

OVERLAY = Path(__file__).resolve().parents[2] / "params/fog_models.yaml"


def run(root: Path, out: Path, model: str) -> int:
    return main(["fog", "--synscapes", str(root), "--out", str(out), "--beta", "0.02", "--model", model])


@pytest.mark.parametrize("model", ["none", "layered:scale_height=10", "heterogeneous:seed=3", "surround:blur=5"])
def test_foggy_fog_writes_what_the_model_gives(tmp_path: Path, model: str) -> None:
    root = write_frames(tmp_path / "synscapes", 1)
    assert run(root, tmp_path / "out", model) == 0
    image, depth = content(1)
    expected = models.apply(model, image, depth, 0.02, CAMERA)
    written = tmp_path / "out/beta_0.02/foggy_img/00001_beta_0.02.png"
    assert np.array_equal(read_rgb(written), expected)
    assert json.loads((tmp_path / "out/settings.json").read_text())["model"] == model
    assert note(written.read_bytes(), NOTE) is None


@pytest.mark.parametrize(("tolerance", "told"), [(0.01, "no model is enough, 0.01 are tolerated"), (200, "200 are")])
def test_auto_notes_in_each_image_which_model_it_took_and_why(tmp_path: Path, tolerance: float, told: str) -> None:
    root = write_frames(tmp_path / "synscapes", 1)
    assert run(root, tmp_path / "out", f"auto:tolerance={tolerance}") == 0
    written = tmp_path / "out/beta_0.02/foggy_img/00001_beta_0.02.png"
    said = note(written.read_bytes(), NOTE)
    assert is_whole_png(written)
    assert said is not None
    assert told in said
    model = said.rpartition(": ")[0]
    image, depth = content(1)
    assert np.array_equal(read_rgb(written), models.apply(model, image, depth, 0.02, CAMERA))


@pytest.mark.parametrize(
    ("model", "told"),
    [
        ("thick", "'thick' is no fog model; there are auto, "),
        ("layered:scale_height=-1", "scale_height is -1 m, expected at least 0.5, at most 100000 m"),
    ],
)
def test_a_wrong_model_is_refused_as_a_wrong_call(tmp_path: Path, model: str, told: str, capsys) -> None:
    assert run(write_frames(tmp_path / "synscapes", 1), tmp_path / "out", model) == 2
    assert told in capsys.readouterr().err


def test_rows_name_their_model_and_its_values_follow() -> None:
    found = params.load(OVERLAY)
    jobs = [job for job in all_jobs(found) if job.step.name == "fog_model"]
    assert {job.values["model"] for job in jobs} == {"layered", "surround"}
    assert all(job.code() == [f"fog_models.{job.values['model']}"] for job in jobs)
    (one,) = {str(job.output("shard").parent) for job in jobs if job.values["model"] == "layered"}
    assert one == "results/fog/layered/beta_0.02"
    assert found.fog.spelt("layered") == "layered"
    assert found.fog_models() == "Fog models: FS-layered: layered; FS-surround: surround."
    assert params.check({}, "params.yaml").fog_models() == ""


@pytest.mark.parametrize(
    ("fog", "told"),
    [
        ({"model": "layered", "values": {"layered": {"scale_height": -2}}}, "scale_height is -2 m, expected at least"),
        ({"values": {"layered": {}}}, "values: layered is neither fog.model nor in fog.also"),
        ({"also": ["layered"]}, r"fog\.also: has layered, but the lists of subset\.modelled ask for none"),
        ({"also": ["homogeneous"]}, "also: models beside homogeneous, each once"),
    ],
)
def test_params_that_do_not_fit_are_named(fog: dict, told: str) -> None:
    with pytest.raises(FoggyError, match=told):
        params.check({"fog": fog}, "params.yaml")
