"""Fog on Synscapes by depth that a simulated stereo camera measured, as jobs: depth, fog, errors, table."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fog_frames import CAMERA, SIZE, content, tree, write_frames
from records import index_of, vouch

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.depth import refinement
from foggy_synscapes.depth.simulation import completed
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages import fog as stage
from foggy_synscapes.stages import tables
from foggy_synscapes.stages.complete import complete_synscapes
from foggy_synscapes.stages.subset import subset

ROOT = Path(__file__).resolve().parents[2]
SHARD = Path("results/fog/completed/beta_0.01/0000.tar")
ROW = "FS-498-completed"


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    """Four frames; the first two and the last one are asked for."""
    monkeypatch.chdir(tmp_path)
    write_frames(Path("synscapes"), 4)
    for frame in range(1, 5):
        labels = np.where(content(frame)[1] > 1000, 23, 7).astype(np.uint8)
        write_bytes(Path("synscapes") / synscapes.class_(frame), encode_png(labels))
    kinds = (synscapes.rgb, synscapes.depth, synscapes.class_)
    write_index(index_of("synscapes", "0000"), Path("synscapes"), [kind(n) for n in range(1, 5) for kind in kinds])
    camera = tuple(vars(CAMERA).values())
    write_csv("results/filter/kept.csv", ("id", *vars(CAMERA)), [(n, *camera) for n in range(1, 5)])
    vouch()
    return change()


def change(**stereo: object) -> Params:
    return check(document(**stereo), "params.yaml")


def document(**stereo: object) -> dict[str, Any]:
    """Params of the experiment on these frames."""
    document, stated = read_yaml(ROOT / "params.yaml"), read_yaml(ROOT / "params/depth_quality.yaml")
    document["scenes"]["roots"]["synscapes"] = "synscapes"
    document["scenes"] |= {"shards": ["0000"], "shard_frames": 4}
    document["stereo"] = stated["stereo"] | {"superpixels": 12} | stereo
    document["fog"] |= {"betas": ["0.01"], "frames": {"first": 2, "last": 1}}
    document["subset"] = {
        kind: {row: entry | {"train": 2, "validation": 1} for row, entry in rows.items()}
        for kind, rows in stated["subset"].items()
    }
    document["train"] = {
        **document["train"],
        **{key: stated["train"][key] for key in ("from_weights", "from_baseline", "rows")},
    }
    document["tables"]["rows"], document["tradeoff"]["row"] = stated["tables"]["rows"][:1], "FS-498"
    return document


def make(params: Params) -> None:
    stage.airlight(params, "0000")
    complete_synscapes(params, "0000")
    stage.fog_completed(params, "0.01", "0000")


def test_fog_is_by_completed_depth_and_the_same_airlight(params: Params) -> None:
    make(params)
    with Shard(SHARD) as shard:
        assert shard.names() == [f"0000{n}_beta_0.01.png" for n in (1, 2, 4)]
        image, depth = content(2)
        found = completed(image, depth, CAMERA, params.stereo.errors(), (1, 2), 12)
        t = refinement.guided(image)(refinement.initial(found, rays(CAMERA), 0.01))
        expected = refinement.composite(image, t, estimate(image).levels)
        np.testing.assert_array_equal(read_rgb(shard.read("00002_beta_0.01.png")), expected)


def test_errors_of_every_pixel_are_in_the_table(params: Params) -> None:
    make(params)
    stage.fog(params, "0.01", "0000")
    tables.depth(params)
    (line,) = [row for row in read_csv("results/tables/depth_quality.csv") if row["by"] == "all"]
    assert int(line["pixels"]) == 3 * SIZE[0] * SIZE[1]
    apart = []
    with Shard(SHARD) as ours, Shard(Path("results/fog/beta_0.01/0000.tar")) as true:
        for name in ours.names():
            pair = [read_rgb(shard.read(name)).astype(float) for shard in (ours, true)]
            apart.append(np.abs(pair[0] - pair[1]).mean())
    assert float(line["levels"]) == pytest.approx(np.mean(apart))
    groups = [row["group"] for row in read_csv("results/tables/depth_quality.csv") if row["by"] == "class"]
    assert groups == ["road", "sky"]
    assert "beta 0.01 / m" in Path("results/tables/depth_quality.md").read_text()


def test_both_lists_are_of_the_same_frames(params: Params) -> None:
    make(params)
    stage.fog(params, "0.01", "0000")
    for row in ("FS-498", ROW):
        subset(params, row)
    true, ours = (
        [line for part in ("train", "validation") for line in read_csv(f"results/subset/{row}/{part}.csv")]
        for row in ("FS-498", ROW)
    )
    assert [line["label"] for line in true] == [line["label"] for line in ours]
    assert [line["image"] for line in ours] == [
        f"fog:completed/beta_0.01/0000.tar#0000{n}_beta_0.01.png" for n in (1, 2, 4)
    ]


def test_an_interrupted_job_goes_on_to_the_same_bytes(params: Params, monkeypatch: pytest.MonkeyPatch) -> None:
    from foggy_synscapes.frames import of_completed_depth

    make(params)
    whole = tree(Path("results/complete"))
    calls = []

    def cut(*arguments: object) -> np.ndarray:
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return completed(*arguments)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(of_completed_depth, "completed", cut)
        with pytest.raises(KeyboardInterrupt):
            complete_synscapes(params, "0000")
    complete_synscapes(params, "0000")
    assert tree(Path("results/complete")) == whole


def test_too_many_superpixels_for_the_images_are_named(params: Params) -> None:
    with pytest.raises(FoggyError, match=r"img/depth/1\.exr: image: 40 x 24 pixels, expected four or more"):
        complete_synscapes(change(superpixels=2048), "0000")


def test_what_the_params_do_not_ask_for_is_refused(params: Params) -> None:
    with pytest.raises(UsageError, match=r"--synscapes-shard 0007: not in scenes\.shards"):
        complete_synscapes(params, "0007")
    with pytest.raises(FoggyError, match=r"stereo: missing, but subset\.completed has FS-498-completed"):
        check(document() | {"stereo": None}, "params.yaml")
