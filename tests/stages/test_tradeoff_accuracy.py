"""tradeoff of fog in mean IoU: the same networks on the same frames, in fog that is made and stored in other ways."""

from pathlib import Path

import numpy as np
import pytest
import torch
from fog_frames import CAMERA, SIZE, content, write_frames
from records import index_of, vouch

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages.tradeoff import tradeoff
from foggy_synscapes.tradeoff.fog import OURS
from foggy_synscapes.tradeoff.fog_accuracy import QUALITIES, REFERENCE, as_jpeg, measure, paragraph, shortcuts
from foggy_synscapes.tradeoff.fog_variants import variants

ROOT = Path(__file__).resolve().parents[2]
BETAS = [0.01, 0.06]


class Bright:
    """Says sky where a pixel is brighter than the middle, and road elsewhere."""

    def predict(self, rgb: np.ndarray) -> np.ndarray:
        return np.where(rgb[..., 1] > 128, 10, 0).astype(np.uint8)


def labels() -> np.ndarray:
    truth = np.full(SIZE, 7, np.uint8)  # road
    truth[:16] = 23  # sky
    return truth


def frames(count: int) -> list:
    return [(*content(frame), CAMERA) for frame in range(1, count + 1)]


@pytest.fixture(scope="module")
def scores() -> dict:
    found, done = measure({"bisenet": Bright()}, frames(6), [labels()] * 6, BETAS, seconds=600)  # type: ignore[dict-item]
    assert done == 6
    return {one.shortcut.name: one for one in found}


def test_every_variant_of_fog_is_scored_beside_airlights_and_files(scores: dict) -> None:
    ways = [variant.name for variant in variants() if variant.name != OURS]
    more = ["airlight of another frame", "grey airlight", *(f"JPEG {quality}" for quality in QUALITIES)]
    assert list(scores) == [REFERENCE, *ways, *more]


def test_what_changes_no_pixel_changes_no_score(scores: dict) -> None:
    for name in (REFERENCE, "float64", "shared powers"):
        assert (scores[name].change, scores[name].ends) == (0, (0, 0))


def test_the_score_is_that_of_a_count_by_hand(scores: dict) -> None:
    (plain,) = [way for way in shortcuts() if way.name == REFERENCE]
    right, union = np.zeros(2), np.zeros(2)
    for frame in frames(6):
        from foggy_synscapes.fog.airlight import estimate

        images, _ = plain.make(frame, estimate(frame[0]).levels, (0, 0, 0), BETAS)
        for image in images:
            guess = image[..., 1] > 128
            for number, (asked, truth) in enumerate(((~guess, labels() == 7), (guess, labels() == 23))):
                right[number] += (asked & truth).sum()
                union[number] += (asked | truth).sum()
    assert scores[REFERENCE].miou == pytest.approx(100 * (right / union).mean())


def test_planar_depth_thins_the_fog_and_keeps_the_road_dark(scores: dict) -> None:
    """Distances that are too short: fewer road pixels turn as bright as the sky."""
    low, high = scores["planar depth"].ends
    assert 0 <= low <= scores["planar depth"].change <= high


def test_a_worse_jpeg_is_smaller(scores: dict) -> None:
    sizes = [scores[f"JPEG {quality}"].size for quality in QUALITIES]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] < scores[REFERENCE].size
    image = content(1)[0]
    far = [int(np.abs(as_jpeg(image, quality)[0].astype(int) - image).sum()) for quality in QUALITIES]
    assert far == sorted(far)


def test_no_frame_is_begun_after_the_time_but_two_are_measured() -> None:
    few, done = measure({"bisenet": Bright()}, frames(5), [labels()] * 5, BETAS, seconds=0)  # type: ignore[dict-item]
    assert done == 2
    assert all(one.ends is not None for one in few)


def test_of_one_frame_nothing_is_said() -> None:
    found, _ = measure({"bisenet": Bright()}, frames(1), [labels()], BETAS, seconds=60)  # type: ignore[dict-item]
    assert paragraph(found) == "**BiSeNet.** Of one image there is no interval: nothing can be said."


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    """Three frames with labels, and a model of the row."""
    monkeypatch.chdir(tmp_path)
    numbers = range(1, 4)
    write_frames(Path("synscapes"), 3)
    for number in numbers:
        write_bytes(Path("synscapes") / synscapes.class_(number), encode_png(labels()))
    paths = [path(n) for n in numbers for path in (synscapes.rgb, synscapes.depth, synscapes.class_)]
    write_index(index_of("synscapes", "0000"), Path("synscapes"), paths)
    write_csv("results/filter/kept.csv", ("id", *vars(CAMERA)), [(n, *vars(CAMERA).values()) for n in numbers])
    torch.manual_seed(0)
    network = build(NetworkConfig("bisenet", "resnet18", 8, 4))
    write_bytes(Path("results/train/bisenet/FS-498/seed-0/model.safetensors"), dump(network, Preprocessing()))
    vouch()
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"]["synscapes"] = "synscapes"
    document["scenes"]["shards"] = ["0000"]
    document["train"]["networks"] = ["bisenet"]
    document["tradeoff"] |= {"row": "FS-498", "betas": ["0.02"], "images": 2}
    return check(document, "params.yaml")


def test_table_and_text_are_written_of_the_last_frames(params: Params) -> None:
    tradeoff(params, "accuracy")
    rows = read_csv("results/tradeoff/accuracy.csv")
    assert [row["shortcut"] for row in rows] == [way.name for way in shortcuts()]
    assert {row["change"] for row in rows if row["shortcut"] == "float64"} == {"0.00"}
    assert "2 of the last 2, each at 1 betas" in Path("results/tradeoff/accuracy.md").read_text()
    assert "longtable" in Path("results/tradeoff/accuracy.tex").read_text()
    assert Path("results/tradeoff/accuracy.run.json").is_file()


def test_a_real_model_predicts_what_is_counted() -> None:
    torch.manual_seed(0)
    model = Model(build(NetworkConfig("bisenet", "resnet18", 8, 4)).eval(), Preprocessing())
    found, _ = measure({"bisenet": model}, frames(2), [labels()] * 2, [0.02], seconds=60)
    assert 0 <= found[0].miou <= 100
