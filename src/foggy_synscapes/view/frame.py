"""The page of one frame: its fog composited in the browser from clear image, distance and airlight."""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.optics import CONTRAST
from foggy_synscapes.view.page import page
from foggy_synscapes.view.planes import bytes_text, distances, words_text

BETAS = ("0.005", "0.01", "0.02", "0.03", "0.06")
"""1/m; what the page has buttons for. Source: paper, section III."""


def frame_page(
    name: str,
    image: np.ndarray,
    depth: np.ndarray,
    rays: Rays,
    light: Airlight,
    estimated: Airlight,
    beta: float,
    betas: Sequence[str] = BETAS,
) -> str:
    """A page on which one frame is fogged at any beta, equal to the rendered image within one grey level.

    Parameters
    ----------
    name : what the page calls the frame
    image : uint8 (H, W, 3), clear
    depth : float32 (H, W), planar metres, at least 0, infinity allowed; ValueError for others
    rays : of the image's camera
    light, estimated : the airlight with which the page begins, and that of the image
    beta : attenuation coefficient in 1/m with which it begins; betas : those it has buttons for
    """
    found = distances(rays.factor() * depth)
    facts = {
        "name": name,
        "width": image.shape[1],
        "height": image.shape[0],
        "nearest": found.nearest,
        "farthest": found.farthest,
        "airlight": light.levels,
        "estimated": estimated.levels,
        "taken": [estimated.row, estimated.column],
        "beta": beta,
        "betas": [float(each) for each in betas],
        "contrast": CONTRAST,
        "worst": found.worst(),
    }
    blobs = {"clear": bytes_text(np.ascontiguousarray(image)), "distance": words_text(found.codes)}
    return page("frame", f"{name} in fog", facts, blobs)
