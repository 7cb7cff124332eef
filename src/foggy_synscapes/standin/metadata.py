"""Metadata of a rendered frame, under the names that Synscapes uses and with values counted from the pixels.

Distances are metres on the ground from the camera; presences are shares, 0 to 1. An instance is listed if at
least one of its pixels is seen.
"""

import math

import numpy as np

from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.canvas import Canvas
from foggy_synscapes.standin.sky import Weather
from foggy_synscapes.standin.street import Street
from foggy_synscapes.standin.traffic import Traffic

KINDS = ("bicyclists", "buses", "cars", "motorcyclists", "pedestrians", "trains", "trucks")
"""Road users that the scene keys count."""


def _visible(canvas: Canvas) -> dict[int, int]:
    numbers, counts = np.unique(canvas.instance, return_counts=True)
    return {int(n): int(c) for n, c in zip(numbers, counts, strict=True) if n}


def describe_instances(canvas: Canvas, rig: Rig) -> dict[str, dict]:
    """The `instance` part: bbox2d, bbox3d, class, occluded and truncated by instance number (as text).

    bbox2d encloses what would be seen of the instance if nothing stood before it, as shares of the image's size,
    with its nearest and farthest planar depth in metres. bbox3d is a box in the camera's frame (right, down,
    forward; metres): its origin and three edges. occluded is the hidden share of the pixels inside the image,
    truncated the share of its projected box outside the image; both 0 to 1.
    """
    described: dict[str, dict] = {name: {} for name in ("bbox2d", "bbox3d", "class", "occluded", "truncated")}
    for number, seen in sorted(_visible(canvas).items()):
        trace, key = canvas.traces[number], str(number)
        extent = trace.extent.reshape(canvas.rows, canvas.columns)
        rows, columns = np.flatnonzero(extent.any(axis=1)), np.flatnonzero(extent.any(axis=0))
        described["bbox2d"][key] = {
            "xmin": int(columns[0]) / canvas.columns,
            "xmax": (int(columns[-1]) + 1) / canvas.columns,
            "ymin": int(rows[0]) / canvas.rows,
            "ymax": (int(rows[-1]) + 1) / canvas.rows,
            "zmin": round(trace.near, 4),
            "zmax": round(trace.far, 4),
        }
        box, corners = _box(trace.corners)
        described["bbox3d"][key] = {name: [round(float(v), 4) for v in vector] for name, vector in box.items()}
        described["class"][key] = trace.label
        described["occluded"][key] = round(1 - seen / int(trace.extent.sum()), 4)
        described["truncated"][key] = round(_outside(corners, rig), 4)
    return described


def _box(pieces: list[np.ndarray]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    # All pieces of an instance share their axes; corner order is x, y, z with z fastest.
    first = pieces[0]
    axes = [first[4] - first[0], first[2] - first[0], first[1] - first[0]]
    axes = [axis / math.sqrt(float((axis * axis).sum())) for axis in axes]
    points = np.concatenate(pieces)
    spans = []
    for axis in axes:
        along = (points * axis).sum(axis=1)
        spans.append((along.min(), along.max()))
    origin = sum(axis * span[0] for axis, span in zip(axes, spans, strict=True))
    edges = [axis * (span[1] - span[0]) for axis, span in zip(axes, spans, strict=True)]
    corners = np.array(
        [origin + a * edges[0] + b * edges[1] + c * edges[2] for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    )
    return {"origin": origin, "x": edges[0], "y": edges[1], "z": edges[2]}, corners


def _outside(corners: np.ndarray, rig: Rig) -> float:
    if corners[:, 2].min() < 0.2:
        corners = corners.copy()
        corners[:, 2] = np.maximum(corners[:, 2], 0.2)
    columns, rows = rig.to_image(corners)
    width, height = np.ptp(columns), np.ptp(rows)
    inner_width = max(0.0, min(rig.resx, columns.max()) - max(0, columns.min()))
    inner_height = max(0.0, min(rig.resy, rows.max()) - max(0, rows.min()))
    return max(0.0, 1 - inner_width * inner_height / (width * height))


def scene_values(
    canvas: Canvas,
    street: Street,
    traffic: Traffic,
    weather: Weather,
    built: dict[str, float],
    rng: np.random.Generator,
) -> dict[str, float]:
    """The `scene` part: all 35 keys, in alphabetical order."""
    distances: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for number in _visible(canvas):
        kind = traffic.kinds[number]
        if kind in distances:
            distances[kind].append(math.hypot(*traffic.places[number]))
    isect = 1.0 if street.crossing is None else min(1.0, street.crossing / 100)
    values: dict[str, float] = {
        "altitude_variation": street.hills,
        "curb_height": street.curb_height,
        "ego_speed": round(float(rng.uniform(0, 14)) * (0.4 + 0.6 * isect), 3),
        "fence_height": round(built["fence_height"], 4),
        "fence_presence": round(min(1.0, built["fence"]), 4),
        "median_presence": 1.0 if street.median else 0.0,
        "parking_angle": street.parking_angle,
        "parking_presence": street.parking_presence,
        "rel_dist_to_isect": round(isect, 4),
        "sidewalk_width": round(sum(street.sidewalks) / 2, 4),
        "sky_contrast": weather.sky_contrast,
        "sun_height": weather.sun_height,
        "wall_height": round(built["wall_height"], 4),
        "wall_presence": round(min(1.0, built["wall"]), 4),
    }
    for kind, found in distances.items():
        mean = sum(found) / len(found) if found else 0.0
        spread = math.sqrt(sum((d - mean) ** 2 for d in found) / len(found)) if found else 0.0
        values[f"num_{kind}"] = len(found)
        values[f"dist_{kind}_mean"] = round(mean, 4)
        values[f"dist_{kind}_stddev"] = round(spread, 4)
    return dict(sorted(values.items()))
