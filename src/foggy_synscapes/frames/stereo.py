"""One frame of a stereo camera from its files: depth completed, transmittance refined, fog; mistakes named by file."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth import disparity as measured
from foggy_synscapes.depth import refinement
from foggy_synscapes.depth.annotation import labels as labels_of
from foggy_synscapes.depth.completion import Stereo, complete
from foggy_synscapes.depth.superpixels import WANTED
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.files import number, parse_json, read_bytes
from foggy_synscapes.io.images import read_grey16, read_rgb

GUIDED, BILATERAL = "guided", "bilateral"
REFINEMENTS = (GUIDED, BILATERAL)
FOGGY, TRANSMITTANCE = "foggy", "transmittance"

DIFFERENT = 0.5
"""Share of matched pixels that look otherwise in the right view, above which the views hardly belong together; in the
real scenes it is 0.08 to 0.15."""

SWAPPED = 0.3, 0.5
"""Left and right are taken for swapped where more than this share looks otherwise, and less than this part of it does
the other way round: real scene 0.08 as it is, 0.39 swapped."""

NEAREST, FARTHEST = 0.5, 2000.0
"""Metres between which the median depth of a street lies, whatever the camera."""


def published(kind: str, refine: str, frame: str, beta: str) -> str:
    """Path of a foggy image or of its transmittance, as Foggy Cityscapes has it.

    >>> published(FOGGY, BILATERAL, "val/lindau/lindau_000000_000019", "0.01")
    'leftImg8bit_foggyDBF/val/lindau/lindau_000000_000019_leftImg8bit_foggy_beta_0.01.png'
    """
    return f"leftImg8bit_{kind}{'DBF' if refine == BILATERAL else ''}/{frame}_leftImg8bit_{kind}_beta_{beta}.png"


@dataclass(frozen=True)
class Source:
    """A file, or its bytes, and what errors call it."""

    file: Path | bytes
    name: str


def of_path(path: Path) -> Source:
    """A file under its own name."""
    return Source(path, str(path))


@dataclass(frozen=True)
class Views:
    """What a stereo camera saw: left and right, uint8 (H, W, 3), and the stored disparity, uint16 (H, W)."""

    left: np.ndarray
    right: np.ndarray
    stored: np.ndarray
    stereo: Stereo
    names: dict[str, str]  # of the files, for messages


def read_views(left: Source, right: Source, disparity: Source, camera: Source) -> Views:
    """Read a frame, and make sure that its files belong together.

    Raises FoggyError, naming the file, where one is missing, damaged or of another kind or size, no pixel has a
    disparity, or left and right are swapped.
    """
    image, other = read_rgb(left.file, left.name), read_rgb(right.file, right.name)
    stored = read_grey16(disparity.file, disparity.name)
    for array, source in ((other, right), (stored, disparity)):
        if array.shape[:2] != image.shape[:2]:
            raise FoggyError(
                f"{source.name}: {_size(array)} pixels, but {left.name} has {_size(image)}. "
                "Are they of the same frame and resolution?"
            )
    if not stored.any():
        raise FoggyError(f"{disparity.name}: all values are 0, so no pixel has a disparity. Fetch the file again.")
    stereo = read_stereo(camera, image.shape[1], image.shape[0])
    names = {"left": left.name, "right": right.name, "disparity": disparity.name, "camera": camera.name}
    return Views(image, other, stored, stereo, names)


def read_stereo(source: Source, width: int, height: int) -> Stereo:
    """The stereo camera of a file of Cityscapes, of images of so many pixels; FoggyError that names what is missing."""
    advice = "Each frame needs its camera, with the baseline."
    data = source.file if isinstance(source.file, bytes) else read_bytes(source.file, "camera file", advice)
    document = parse_json(data, source.name, "camera file", advice)
    baseline = _number(document, "extrinsic", "baseline", source.name)
    numbers = {name: _number(document, "intrinsic", name, source.name) for name in ("fx", "fy", "u0", "v0")}
    try:
        return Stereo(Camera(**numbers, resx=width, resy=height), baseline)
    except ValueError as error:
        raise FoggyError(f"{source.name}: {error}") from error


def _number(document: Any, section: str, key: str, name: str) -> float:
    try:
        return number(document[section][key])
    except (KeyError, TypeError, IndexError):
        needs = "metres between both cameras" if key == "baseline" else "pixels"
        raise FoggyError(f"{name}: {section}.{key} missing, in {needs}. Is this a camera file of Cityscapes?") from None
    except ValueError as error:
        raise FoggyError(f"{name}: {section}.{key}: {error}") from error


def completed(views: Views, seed: int, wanted: int = WANTED) -> tuple[np.ndarray, list[str]]:
    """Completed depth, float64 (H, W), planar metres; and what may be wrong with the frame.

    Raises FoggyError that names the file where the depth cannot be completed, or left and right are swapped.
    """
    try:
        found = complete(views.left, views.right, views.stored, views.stereo, seed, wanted)
    except ValueError as error:
        _refuse_swapped(views, measured.inconsistent(views.left, views.right, views.stored))
        raise FoggyError(f"{views.names['disparity']}: {error}") from error
    warnings, different = [], _refuse_swapped(views, found.inconsistent)
    if different > DIFFERENT:
        warnings.append(
            f"{views.names['right']}: {different:.0%} of the matched pixels look otherwise than in "
            f"{views.names['left']}. Are both, and the disparity, of one frame?"
        )
    if (views.left == views.left[0, 0]).all():
        warnings.append(f"{views.names['left']}: has one colour only, so its superpixels follow nothing")
    finite = found.depth[np.isfinite(found.depth)]
    median = float(np.median(finite)) if finite.size else NEAREST
    if not NEAREST <= median <= FARTHEST:
        warnings.append(
            f"{views.names['camera']}: with its baseline of {views.stereo.baseline:g} m the median depth is "
            f"{median:.3g} m. Is the baseline in metres, and fx that of this resolution?"
        )
    return found.depth, warnings


def _refuse_swapped(views: Views, inconsistent: np.ndarray) -> float:
    """The share of matched pixels that look otherwise; FoggyError where that is because left and right are swapped."""
    matched = views.stored > 0
    different, (many, part) = float(inconsistent[matched].mean()), SWAPPED
    if different > many:
        back = float(measured.inconsistent(views.right, views.left, views.stored)[matched].mean())
        if back < part * different:
            raise FoggyError(
                f"{views.names['left']} and {views.names['right']}: {different:.0%} of the matched pixels look "
                f"otherwise in the right image, but {back:.0%} with both swapped. Swap left and right."
            )
    return different


class Refined:
    """Refined transmittance of a frame at any beta.

    image : uint8 (H, W, 3); depth : float64 (H, W); ids : instance ids, where `refine` is bilateral

    Raises FoggyError that names the ids where they do not belong to the image.
    """

    def __init__(
        self, image: np.ndarray, depth: np.ndarray, camera: Camera, geometry: str, refine: str, ids: Source | None
    ) -> None:
        self.image, self._depth, self._rays = image, depth, rays(camera, geometry)
        if refine == GUIDED:
            self._refine = refinement.guided(image)
            return
        if ids is None:
            raise ValueError(f"refine {refine} needs instance ids")
        found = read_grey16(ids.file, ids.name)
        if found.shape != image.shape[:2]:
            raise FoggyError(f"{ids.name}: {_size(found)} pixels, but the image has {_size(image)}")
        try:
            self._refine = refinement.bilateral(image, labels_of(found))
        except ValueError as error:
            raise FoggyError(f"{ids.name}: {error}") from error

    def transmittance(self, beta: str) -> np.ndarray:
        """At an attenuation coefficient in 1/m: float64 (H, W)."""
        return self._refine(refinement.initial(self._depth, self._rays, float(beta)))

    def foggy(self, betas: list[str], airlight: tuple[int, int, int]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Foggy image, uint8 (H, W, 3), and transmittance in 8 bits, uint8 (H, W), at each beta."""
        for beta in betas:
            values = self.transmittance(beta)
            yield refinement.composite(self.image, values, airlight), refinement.levels(values)


def _size(values: np.ndarray) -> str:
    return f"{values.shape[1]} x {values.shape[0]}"
