"""The published stereo code's results on a real scene, a real crop and a generated case: equal in every pixel.

cropA_n128 and synth_n60 are the same images with fewer superpixels, so that these have a usual size.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth import annotation, refinement
from foggy_synscapes.depth.completion import Completed, Stereo, complete
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.images import read_grey16, read_ids, read_rgb

CASES = {"dusseldorf": 2048, "cropA": 2048, "cropA_n128": 128, "synth": 2048, "synth_n60": 60}
"""Superpixels wanted, by case."""

BETAS = {"gf": (0.005, 0.01, 0.02), "dbf": (0.01,)}


@dataclass(frozen=True)
class Case:
    name: str
    data: Path

    @property
    def reference(self) -> Path:
        return self.data / "stereo_reference" / self.name

    def input(self, kind: str, ending: str) -> Path:
        if self.name == "dusseldorf":
            root, stem = self.data / "cityscapes", "train/dusseldorf/dusseldorf_000020_000019"
        else:
            stem = self.name.partition("_")[0]
            root = self.data / "stereo_reference" / f"{stem}_inputs"
        return root / kind / f"{stem}_{ending}"

    @cached_property
    def left(self) -> np.ndarray:
        return read_rgb(self.input("leftImg8bit", "leftImg8bit.png"))

    @cached_property
    def stereo(self) -> Stereo:
        camera = json.loads(self.input("camera", "camera.json").read_text())
        numbers = {name: camera["intrinsic"][name] for name in ("fx", "fy", "u0", "v0")}
        return Stereo(
            Camera(**numbers, resx=self.left.shape[1], resy=self.left.shape[0]), camera["extrinsic"]["baseline"]
        )

    @cached_property
    def completed(self) -> Completed:
        right = read_rgb(self.input("rightImg8bit", "rightImg8bit.png"))
        stored = read_grey16(self.input("disparity", "disparity.png"))
        return complete(self.left, right, stored, self.stereo, wanted=CASES[self.name])

    @cached_property
    def labels(self) -> np.ndarray:
        return annotation.labels(read_grey16(self.input("gtFine", "gtFine_instanceIds.png")))

    @cached_property
    def segments(self) -> dict[str, np.ndarray]:
        return dict(np.load(self.reference / "segments.npz"))

    def transmittance(self, kind: str, beta: float) -> np.ndarray:
        refine = refinement.guided(self.left) if kind == "gf" else refinement.bilateral(self.left, self.labels)
        return refine(refinement.initial(self.completed.depth, rays(self.stereo.camera), beta))


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest, real_data: Path) -> Case:
    if not (real_data / "stereo_reference" / request.param).is_dir():
        pytest.skip(f"no results of the published stereo code at {real_data / 'stereo_reference' / request.param}")
    return Case(request.param, real_data)


def test_masks_are_equal(case: Case) -> None:
    np.testing.assert_array_equal(case.completed.missing, read_ids(case.reference / "invalid_mask.png") > 0)
    np.testing.assert_array_equal(case.completed.inconsistent, read_ids(case.reference / "photo_outlier_mask.png") > 0)


def test_superpixels_are_equal(case: Case) -> None:
    np.testing.assert_array_equal(case.completed.segments.labels, read_grey16(case.reference / "slic_labels.png"))


def test_draws_rounds_and_inliers_of_every_plane_are_equal(case: Case) -> None:
    ours, theirs = case.completed.segments, case.segments
    np.testing.assert_array_equal(ours.own, theirs["visible"])
    np.testing.assert_array_equal(np.flatnonzero(ours.rounds), theirs["ransac_segment"])
    np.testing.assert_array_equal(ours.rounds[theirs["ransac_segment"]], theirs["ransac_iterations"])
    np.testing.assert_array_equal(ours.inliers[theirs["ransac_segment"]], theirs["ransac_inliers"])
    assert ours.draws == theirs["ransac_cumulative_draws"][-1]


def test_matches_and_their_order_are_equal(case: Case) -> None:
    ours, theirs = case.completed.segments, case.segments
    visible, unseen, own = theirs["visible_ids"], theirs["invisible_ids"], theirs["match_is_visible"]
    index = theirs["match_index"]
    partners = np.where(own, visible[np.where(own, index, 0)], unseen[np.where(own, 0, index)])
    np.testing.assert_array_equal(ours.partners[unseen], partners)
    np.testing.assert_array_equal(ours.order, unseen[theirs["match_order"]])
    np.testing.assert_array_equal(np.isinf(ours.planes[:, 0]), theirs["is_plane_at_inf"])


def test_depth_is_equal_to_a_millionth_and_infinity_exactly(case: Case) -> None:
    ours, theirs = case.completed.depth, np.load(case.reference / "depth.npz")["depth"]
    np.testing.assert_array_equal(np.isinf(ours), np.isinf(theirs))
    np.testing.assert_array_equal(ours == 0, theirs == 0)
    near = np.isfinite(ours)
    np.testing.assert_allclose(ours[near], theirs[near], rtol=1e-6, atol=0)


def test_the_airlight_is_of_the_same_pixel(case: Case) -> None:
    theirs, ours = json.loads((case.reference / "airlight.json").read_text()), estimate(case.left)
    assert [ours.row, ours.column] == theirs["airlight_row_col_0based"]
    assert list(ours.levels) == theirs["airlight_rgb8"]


def test_labels_of_the_bilateral_filter_are_equal(case: Case) -> None:
    theirs = read_grey16(case.reference / "dbf_labels.png").astype(int)  # from 1
    np.testing.assert_array_equal(case.labels, theirs - 1)


@pytest.mark.parametrize("kind", BETAS)
def test_fog_is_equal_in_every_pixel(case: Case, kind: str) -> None:
    light = estimate(case.left).levels
    for beta in BETAS[kind]:
        stem = f"{kind}_{beta}".replace(".", "p")
        refined = case.transmittance(kind, beta)
        foggy = refinement.composite(case.left, refined, light)
        np.testing.assert_array_equal(foggy, read_rgb(case.reference / f"foggy_{stem}.png"), stem)
        stored = case.reference / f"t_{stem}_u16.png"
        if stored.is_file():  # t x 65535, rounded
            np.testing.assert_allclose(refined * 65535, read_grey16(stored), atol=0.5 + 1e-6)


WRONG: dict[str, Callable[[Case], np.ndarray]] = {
    "another seed": lambda case: complete_with(case, seed=1),
    "fewer superpixels": lambda case: complete_with(case, wanted=1500),
}


def complete_with(case: Case, **options: int) -> np.ndarray:
    right = read_rgb(case.input("rightImg8bit", "rightImg8bit.png"))
    return complete(
        case.left, right, read_grey16(case.input("disparity", "disparity.png")), case.stereo, **options
    ).depth


@pytest.mark.parametrize("change", WRONG)
def test_the_comparison_would_notice(real_data: Path, change: str) -> None:
    case = Case("cropA", real_data)
    if not case.reference.is_dir():
        pytest.skip(f"no results of the published stereo code at {case.reference}")
    theirs = np.load(case.reference / "depth.npz")["depth"]
    assert not np.allclose(WRONG[change](case), theirs, rtol=1e-6)
