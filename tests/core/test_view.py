"""Pages to look at: what they carry is exact enough at every density, and their colours are told apart by all."""

import base64
import json
import math
import re
import zlib

import numpy as np
import pytest

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.labels import CLASSES, PALETTE
from foggy_synscapes.view.colours import RIGHT, SAFE, WRONG
from foggy_synscapes.view.frame import BETAS, frame_page
from foggy_synscapes.view.page import script
from foggy_synscapes.view.planes import FARTHEST, INFINITE, bytes_text, distances, words_text
from foggy_synscapes.view.predictions import Row, Shown, predictions_page

CAMERA = Camera(fx=1590.0, fy=1590.0, u0=160.0, v0=90.0, resx=320, resy=180)
RAYS = rays(CAMERA)
FLOAT32 = 0.001  # grey levels that the shader's arithmetic may add to `Distances.worst`


def shader(image: np.ndarray, metres: np.ndarray, light: tuple[int, ...], beta: float) -> np.ndarray:
    """The levels before they are rounded, in the float32 of templates/painters.js: float32 (H, W, 3)."""
    far = np.minimum(metres, np.float32(1e30))
    t = np.exp(-np.minimum(np.float32(beta) * far, np.float32(100)))
    lit = np.array(light, np.float32)
    return lit + (image.astype(np.float32) - lit) * t[..., None]


def exact(image: np.ndarray, metres: np.ndarray, light: tuple[int, ...], beta: float) -> np.ndarray:
    """The same in float64."""
    lit = np.array(light, float)
    return lit + (image - lit) * np.exp(-beta * metres)[..., None]


def scene(seed: int, nearest: float, farthest: float) -> tuple[np.ndarray, np.ndarray]:
    """An image of the extremes and of noise, and distances over a range, with missing ones and an infinite sky."""
    rng = np.random.default_rng(seed)
    image = rng.choice(np.array([0, 255, 128, 17], np.uint8), (180, 320, 3))
    depth = np.exp(rng.uniform(math.log(nearest), math.log(farthest), (180, 320))).astype(np.float32)
    depth[:20], depth[20] = np.inf, 0
    return image, depth


@pytest.mark.parametrize(("nearest", "farthest"), [(5.4, 8935), (0.1, 1e5), (1e-30, 1e30), (20, 20)])
def test_stored_distances_move_no_pixel_by_more_than_promised_at_any_density(nearest: float, farthest: float) -> None:
    image, depth = scene(1, nearest, farthest)
    metres = RAYS.factor() * depth
    found = distances(metres)
    assert found.worst() < (0.006 if farthest < 1e4 else 0.14)
    # Off the paper's betas, too: the bound is for all of them.
    for beta in (0, 1e-9, 1e-4, *map(float, BETAS), 0.3, 7.0, 1e3):
        for light in ((251, 255, 249), (0, 0, 0), (255, 0, 255)):
            real = exact(image, np.where(np.isinf(metres), 1e300, metres), light, beta)
            moved = np.abs(shader(image, found.metres(), light, beta) - real)
            assert moved.max() <= found.worst() + FLOAT32


@pytest.mark.parametrize("beta", BETAS)
def test_the_shader_in_float32_is_within_one_level_of_the_rendered_image(beta: str) -> None:
    image, depth = scene(2, 5.4, 8935)
    light = estimate(image)
    rendered = foggy_images(image, depth, RAYS, light.levels, [float(beta)])[0].astype(int)
    found = distances(RAYS.factor() * depth)
    drawn = np.floor(shader(image, found.metres(), light.levels, float(beta)) + np.float32(0.5)).astype(int)
    differs = np.abs(drawn - rendered)
    assert differs.max() <= 1
    # Only values that lie as close to the edge between two levels as they may have moved.
    assert differs.mean() <= 2 * (found.worst() + FLOAT32)


def test_the_bound_is_reached_and_not_far_above_what_happens() -> None:
    image = np.full((180, 320, 3), 255, np.uint8)
    depth = np.exp(np.linspace(math.log(5), math.log(9000), image.shape[0] * image.shape[1])).reshape(180, 320)
    found = distances(depth)
    stored = found.nearest * np.exp(found.step * (found.codes - 1.0))
    moved = max(
        np.abs(exact(image, stored, (0, 0, 0), beta) - exact(image, depth, (0, 0, 0), beta)).max()
        for beta in (0.005, 0.02, 0.06)
    )
    assert 0.9 * found.worst() < moved <= found.worst() * (1 + 1e-6)


def test_distance_zero_and_infinity_are_kept() -> None:
    found = distances(np.array([[0, 3, 7, np.inf]]))
    assert found.codes.tolist() == [[0, 1, FARTHEST, INFINITE]]
    assert (found.metres()[0, 0], found.metres()[0, 3]) == (0, np.inf)
    nothing = distances(np.full((2, 2), np.inf))
    assert np.isinf(nothing.metres()).all()
    assert nothing.worst() == 0
    for wrong in ([[-1.0]], [[np.nan]], [1.0]):
        with pytest.raises(ValueError, match="metres"):
            distances(np.array(wrong))


def unfolded(text: str, shape: tuple[int, int]) -> np.ndarray:
    """What templates/planes.js reads from the text of 16-bit numbers."""
    high, low = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, *shape).astype(np.int64)
    folded = high << 8 | low
    return np.cumsum((folded >> 1) ^ -(folded & 1), axis=0) % 65536


def test_arrays_come_back_from_their_text() -> None:
    rng = np.random.default_rng(3)
    words = rng.integers(0, 65536, (9, 5)).astype(np.uint16)
    words[:2] = [[0], [65535]]
    assert (unfolded(words_text(words), (9, 5)) == words).all()
    image = rng.integers(0, 256, (9, 5, 3)).astype(np.uint8)
    held = np.frombuffer(zlib.decompress(base64.b64decode(bytes_text(image))), np.uint8).reshape(image.shape)
    assert (np.cumsum(held, axis=0, dtype=np.uint8) == image).all()
    with pytest.raises(ValueError, match="expected uint8"):
        bytes_text(words)
    with pytest.raises(ValueError, match="expected uint16"):
        words_text(image)


def test_a_page_is_whole_and_asks_for_nothing() -> None:
    image, depth = scene(4, 5, 500)
    light = Airlight(1, 2, 3, 4, 5)
    text = frame_page("</script><b>&.png", image, depth, RAYS, light, estimate(image), 0.02)
    assert text == frame_page("</script><b>&.png", image, depth, RAYS, light, estimate(image), 0.02)
    assert text.count("</script>") == 4  # facts, two arrays, the module: the name closes none
    facts = json.loads(re.search(r'id="facts">(.*?)</script>', text)[1])
    assert (facts["name"], facts["airlight"]) == ("</script><b>&.png", [1, 2, 3])
    assert not re.search(r"https?:|//www|@import|url\((?!#)|<link(?! rel=\"icon\" href=\"data:)|{{", text)


@pytest.mark.parametrize("name", ["frame", "predictions"])
def test_modules_are_joined_without_imports_and_each_once(name: str) -> None:
    text = script(name)
    assert not re.search(r"^\s*(import|export)\b", text, re.MULTILINE)
    modules = re.findall(r"^const (\w+)_module = ", text, re.MULTILINE)
    assert modules[-1] == name
    assert len(set(modules)) == len(modules)
    for used in re.findall(r"= (\w+)_module;", text):
        assert modules.index(used) < len(modules) - 1


def test_a_page_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="0 images of 1 rows"):
        predictions_page("nothing", [Row("Net", "C", None)], [])


def test_scores_of_an_image_are_those_of_its_pixels() -> None:
    truth = np.array([[0, 0, 1, 255]], np.uint8)
    guess = np.array([[0, 1, 1, 13]], np.uint8)
    text = predictions_page("t", [Row("Net", "C", 50.0)], [Shown("a.png", b"jpeg", truth, [guess])])
    facts = json.loads(re.search(r'id="facts">(.*?)</script>', text)[1])
    image = facts["images"][0]
    assert image["scores"][0]["mean"] == 50
    assert image["scores"][0]["classes"][:3] == [50, 50, None]
    assert image["pixels"][:2] == [2, 1]
    assert sum(image["pixels"]) == 3


# Severity 1.0, on linear RGB. Source: Machado, Oliveira and Fernandes, 2009, table 1.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]
    ],
}  # fmt: skip
TO_XYZ = [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
WHITE = (0.95047, 1.0, 1.08883)  # D65, IEC 61966-2-1


def lab(colours: np.ndarray, sight: str) -> np.ndarray:
    """CIELAB of 8-bit sRGB colours (N, 3) as a kind of sight has them."""
    share = colours / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ np.array(SIGHT[sight]).T, 0, 1) @ np.array(TO_XYZ).T / WHITE
    f = np.where(seen > 216 / 24389, np.cbrt(seen), (24389 / 27 * seen + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def ciede2000(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Colour differences by Sharma, Wu and Dalal (2005), of CIELAB colours (..., 3)."""
    chroma = (np.hypot(one[..., 1], one[..., 2]) + np.hypot(other[..., 1], other[..., 2])) / 2
    stretch = 1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    (a1, b1), (a2, b2) = ((each[..., 1] * stretch, each[..., 2]) for each in (one, other))
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    turn = np.where(c1 * c2 == 0, 0, (h2 - h1 + 180) % 360 - 180)
    light, strong = other[..., 0] - one[..., 0], c2 - c1
    hue = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn) / 2)
    mean_light, mean_strong = (one[..., 0] + other[..., 0]) / 2, (c1 + c2) / 2
    mean_hue = np.where(c1 * c2 == 0, h1 + h2, (h1 + turn / 2) % 360)
    cosines = [np.cos(np.radians(k * mean_hue - at)) for k, at in ((1, 30), (2, 0), (3, -6), (4, 63))]
    weight = 1 - 0.17 * cosines[0] + 0.24 * cosines[1] + 0.32 * cosines[2] - 0.20 * cosines[3]
    rotated = 2 * np.sqrt(mean_strong**7 / (mean_strong**7 + 25.0**7))
    rotated = -rotated * np.sin(np.radians(60 * np.exp(-(((mean_hue - 275) / 25) ** 2))))
    bright = light / (1 + 0.015 * (mean_light - 50) ** 2 / np.sqrt(20 + (mean_light - 50) ** 2))
    strong, hue = strong / (1 + 0.045 * mean_strong), hue / (1 + 0.015 * mean_strong * weight)
    return np.sqrt(bright**2 + strong**2 + hue**2 + rotated * strong * hue)


def closest(colours: np.ndarray, sight: str) -> float:
    """The smallest difference between any two colours."""
    seen = lab(colours.astype(float), sight)
    return float(ciede2000(seen[:, None], seen[None])[np.triu_indices(len(colours), 1)].min())


@pytest.mark.parametrize(
    ("one", "other", "expected"),  # of the test data of Sharma, Wu and Dalal, table 1: pairs 1, 7, 17, 25, 33
    [
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, 0, 0), (50, -1, 2), 2.3669),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((6.7747, -0.2908, -2.4247), (5.8714, -0.0985, -2.2286), 0.6377),
    ],
)
def test_differences_are_those_of_the_published_data(one: tuple, other: tuple, expected: float) -> None:
    assert float(ciede2000(np.array(one, float), np.array(other, float))) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("sight", SIGHT)
def test_safe_colours_are_told_apart_in_every_kind_of_sight(sight: str) -> None:
    assert SAFE.shape == PALETTE.shape == (len(CLASSES), 3)
    assert closest(np.vstack([SAFE, [[0, 0, 0]]]), sight) > 14.4
    assert closest(np.array([RIGHT, WRONG]), sight) > 25


def test_the_colours_of_cityscapes_are_not() -> None:
    vehicles = PALETTE[[CLASSES.index(name) for name in ("car", "truck", "motorcycle", "bus", "train")]]
    assert closest(vehicles, "deuteranopia") < 7
    assert closest(PALETTE, "deuteranopia") == pytest.approx(2.6, abs=0.1)
