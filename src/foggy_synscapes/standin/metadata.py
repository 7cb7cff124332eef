"""Metadata of a rendered frame, under the names that Synscapes uses and with values counted from the pixels.

Distances are metres on the ground from the camera; presences are shares, 0 to 1. An instance is listed if at
least one of its pixels is seen.
"""

import math
from itertools import product

import numpy as np

from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.canvas import STRIDE, Canvas
from foggy_synscapes.standin.street import Street
from foggy_synscapes.standin.traffic import Traffic

KINDS = ("bicyclists", "buses", "cars", "motorcyclists", "pedestrians", "trains", "trucks")
"""Road users that the scene keys count."""


def describe_instances(canvas: Canvas) -> dict[str, dict]:
    """The `instance` part: bbox2d, bbox3d, class, occluded and truncated by instance number (as text).

    bbox2d encloses what would be seen of the instance if nothing stood before it, as shares of the image's size,
    with its nearest and farthest planar depth in metres. bbox3d is a box in the camera's frame (right, down,
    forward; metres): its origin and three edges. occluded is the hidden share of the pixels inside the image,
    truncated the share of its projected box outside the image; both 0 to 1.
    """
    described: dict[str, dict] = {name: {} for name in ("bbox2d", "bbox3d", "class", "occluded", "truncated")}
    rows, columns = canvas.number.shape
    for number, seen in _visible(canvas).items():
        trace, key = canvas.traces[number], str(number)
        high, wide = np.flatnonzero(trace.extent.any(axis=1)), np.flatnonzero(trace.extent.any(axis=0))
        described["bbox2d"][key] = {
            "xmin": int(wide[0]) / columns,
            "xmax": (int(wide[-1]) + 1) / columns,
            "ymin": int(high[0]) / rows,
            "ymax": (int(high[-1]) + 1) / rows,
            "zmin": round(trace.near, 4),
            "zmax": round(trace.far, 4),
        }
        origin, (x, y, z) = _box(trace.corners)
        box = {"origin": origin, "x": x, "y": y, "z": z}
        described["bbox3d"][key] = {name: [round(v, 4) for v in vector.tolist()] for name, vector in box.items()}
        described["class"][key] = number // STRIDE
        described["occluded"][key] = round(1 - seen / int(trace.extent.sum()), 4)
        corners = np.array([origin + a * x + b * y + c * z for a, b, c in product((0, 1), repeat=3)])
        described["truncated"][key] = round(_outside(corners, canvas.rig), 4)
    return described


def _visible(canvas: Canvas) -> dict[int, int]:
    numbers, counts = np.unique(canvas.number, return_counts=True)
    return {number: count for number, count in zip(numbers.tolist(), counts.tolist(), strict=True) if number > STRIDE}


def _box(pieces: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    # Origin and edges. All pieces of an instance share their axes; corner order is x, y, z with z fastest.
    first, points = pieces[0], np.concatenate(pieces)
    edges = [first[corner] - first[0] for corner in (4, 2, 1)]
    axes = [edge / math.sqrt(float((edge * edge).sum())) for edge in edges]
    along = [(points * axis).sum(axis=1) for axis in axes]
    origin = sum(axis * place.min() for axis, place in zip(axes, along, strict=True))
    return origin, [axis * (place.max() - place.min()) for axis, place in zip(axes, along, strict=True)]


def _outside(corners: np.ndarray, rig: Rig) -> float:
    seen, whole = 1.0, 1.0
    for places, length in zip(rig.to_image(corners), (rig.resx, rig.resy), strict=True):
        seen *= max(0.0, min(length, places.max()) - max(0, places.min()))
        whole *= places.max() - places.min()
    return max(0.0, 1 - seen / whole)


def scene_values(
    canvas: Canvas, street: Street, traffic: Traffic, built: dict[str, tuple[float, float]]
) -> dict[str, float]:
    """The `scene` part: all 35 keys, in alphabetical order."""
    rng, weather = canvas.style.rng, canvas.style.weather
    isect = min(1.0, street.crossing[0] / 100)
    values: dict[str, float] = {
        "altitude_variation": street.hills,
        "curb_height": street.curb_height,
        "ego_speed": round(rng.uniform(0, 14) * (0.4 + 0.6 * isect), 3),
        "median_presence": 1.0 if street.median else 0.0,
        "parking_angle": street.parking_angle,
        "parking_presence": street.parking_presence,
        "rel_dist_to_isect": round(isect, 4),
        "sidewalk_width": round(sum(side.sidewalk for side in street.sides) / 2, 4),
        "sky_contrast": weather.sky_contrast,
        "sun_height": weather.sun_height,
    }
    for kind in ("fence", "wall"):
        values[f"{kind}_presence"], values[f"{kind}_height"] = (round(value, 4) for value in built[kind])
    seen = [traffic.instances[number] for number in _visible(canvas)]
    for kind in KINDS:
        found = [distance for name, distance in seen if name == kind]
        mean = sum(found) / len(found) if found else 0.0
        spread = math.sqrt(sum((d - mean) ** 2 for d in found) / len(found)) if found else 0.0
        values[f"num_{kind}"] = len(found)
        values[f"dist_{kind}_mean"] = round(mean, 4)
        values[f"dist_{kind}_stddev"] = round(spread, 4)
    return dict(sorted(values.items()))
