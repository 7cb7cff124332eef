"""Surfaces of solids: facades, walls, fences, hedges, kerbs and vehicles.

Each maker draws a look once and returns a shader (see `canvas.Shader`). `grain` is the strength of fine texture:
small in the synthetic domain, larger in the real one.
"""

import numpy as np

from foggy_synscapes.standin.canvas import Hit, Shader
from foggy_synscapes.standin.noise import noise

LEFT, RIGHT, BOTTOM, TOP, FRONT, BACK = range(6)


def colour(*rgb: float) -> np.ndarray:
    """An 8-bit colour as float32 in [0, 1]."""
    return np.array(rgb, np.float32) / np.float32(255)


FACADES = (
    (150, 72, 52), (172, 98, 66), (196, 178, 142), (150, 148, 142), (206, 200, 184),
    (176, 146, 96), (120, 132, 110), (132, 104, 88), (110, 112, 120), (190, 160, 150),
)  # fmt: skip
PAINTS = (
    (150, 22, 24), (28, 44, 96), (26, 28, 32), (198, 200, 204), (120, 124, 130),
    (60, 64, 68), (210, 208, 200), (34, 70, 58), (140, 110, 60), (56, 96, 150),
)  # fmt: skip
GLASS = colour(34, 42, 50)


def _base(hit: Hit, rgb: np.ndarray, pattern: np.ndarray) -> np.ndarray:
    return rgb[None, :] * pattern[:, None]


def _sideways(hit: Hit) -> np.ndarray:
    # Horizontal coordinate on an upright face: z on the sides, x on front and back.
    return np.where(hit.face <= RIGHT, hit.z, hit.x)


def facade(rng: np.random.Generator, height: float, grain: float, glare: float) -> Shader:
    """Windows in storeys on a coloured wall; `glare` is how much sky the panes mirror."""
    wall = colour(*FACADES[rng.integers(len(FACADES))]) * np.float32(rng.uniform(0.8, 1.08))
    trim = colour(*(60, 58, 56)) if rng.random() < 0.4 else np.minimum(wall * np.float32(1.25), 0.9)
    storey, bay = rng.uniform(2.8, 3.5), rng.uniform(2.0, 3.4)
    wide, tall = rng.uniform(0.22, 0.36), rng.uniform(0.26, 0.36)
    shop, phase = rng.random() < 0.35, rng.uniform(0, 8)
    brick = rng.random() < 0.5

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        a, b = _sideways(hit), hit.y
        fade = np.minimum(1.0, 18.0 / hit.depth)
        pattern = 1.0 + grain * noise(a + phase, b, 9.0) * fade + 0.6 * grain * noise(a, b + phase, 4.0)
        if brick:
            course = (b * 6).astype(np.int32) & 1
            pattern *= 1.0 - (0.03 + 0.4 * grain) * course * fade
        pattern *= 0.82 + 0.18 * np.minimum(1, b / 2.5)
        rgb = _base(hit, wall, pattern.astype(np.float32))
        column, row = np.floor((a + phase) / bay), np.floor(b / storey)
        u, v = np.abs((a + phase) / bay - column - 0.5), np.abs(b / storey - row - 0.52)
        frame = (u < wide + 0.04) & (v < tall + 0.04)
        pane = (u < wide) & (v < tall)
        if shop:
            ground = row == 0
            frame |= ground & (v < 0.42)
            pane = np.where(ground, (u < 0.45) & (v < 0.36), pane)
        below_roof = b < height - 0.5
        rgb[frame & below_roof] = trim
        lively = noise(column * 7.0 + row * 3.0, row * 5.0 + column, 3.0)
        mirror = np.clip(0.45 * glare * (0.6 + lively) + 0.05 * grain, 0, 0.6).astype(np.float32)
        glass = GLASS[None, :] * (1 - mirror[:, None]) + mirror[:, None] * colour(200, 214, 226)
        rgb[pane & below_roof] = glass[pane & below_roof]
        rgb[b > height - 0.35] *= np.float32(0.7)
        return rgb, None

    return shade


def plain(rng: np.random.Generator, rgb: tuple[float, float, float], grain: float, scale: float = 5.0) -> Shader:
    """One colour with grain: roofs, kerbs, pavements, bins."""
    base = colour(*rgb) * np.float32(rng.uniform(0.9, 1.1))

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        fade = np.minimum(1.0, 14.0 / hit.depth)
        pattern = (
            1.0
            + grain * noise(hit.x + hit.y, hit.z - hit.y, scale) * fade
            + 0.6 * grain * noise(hit.x, hit.z + hit.y, 3.0)
        )
        return _base(hit, base, pattern.astype(np.float32)), None

    return shade


def paving(rng: np.random.Generator, grain: float) -> Shader:
    """Slabs or cobbles of a sidewalk with a lighter kerb."""
    base = colour(*((138, 134, 130), (124, 122, 120), (146, 138, 128))[rng.integers(3)])
    slab = rng.uniform(0.4, 0.9)

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        fade = np.minimum(1.0, 8.0 / hit.depth)
        u, v = hit.x / slab, hit.z / slab
        joint = ((u - np.floor(u)) < 0.1) | ((v - np.floor(v)) < 0.1)
        tone = noise(np.floor(u), np.floor(v), 1.0)
        pattern = 1.0 + grain * (0.9 * tone + 0.7 * noise(hit.x, hit.z, 11.0)) * fade - (0.1 + grain) * joint * fade
        rgb = _base(hit, base, pattern.astype(np.float32))
        rgb[hit.face != TOP] *= np.float32(0.75)
        return rgb, None

    return shade


def masonry(rng: np.random.Generator, grain: float) -> Shader:
    """A free-standing wall of concrete, stone or brick with a coping."""
    base = colour(*((152, 150, 156), (128, 124, 130), (146, 96, 82), (168, 160, 150))[rng.integers(4)])
    block, course = rng.uniform(0.8, 1.6), rng.uniform(0.35, 0.6)

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        a = _sideways(hit)
        row = np.floor(hit.y / course)
        u = a / block + 0.5 * (row % 2)
        fade = np.minimum(1.0, 20.0 / hit.depth)
        joint = ((u - np.floor(u)) < 0.06) | ((hit.y / course - row) < 0.12)
        pattern = (
            1.0
            + grain * (noise(np.floor(u) + row * 13, row, 1.0) + 0.6 * noise(a, hit.y, 7.0)) * fade
            - 0.22 * joint * fade
        )
        return _base(hit, base, pattern.astype(np.float32)), None

    return shade


def palings(rng: np.random.Generator, grain: float) -> Shader:
    """A fence: bars or planks with rails before a dark ground."""
    bars = colour(*((120, 92, 64), (70, 76, 74), (176, 170, 160), (84, 96, 70))[rng.integers(4)])
    pitch, fill, top = rng.uniform(0.35, 0.7), rng.uniform(0.35, 0.6), rng.uniform(0.0, 0.3)

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        a = _sideways(hit)
        u = a / pitch - np.floor(a / pitch)
        bar = (u < fill) | (np.abs(hit.y - 0.25) < 0.07) | (np.abs(hit.y - 0.95 - top) < 0.07)
        pattern = 1.0 + grain * noise(a, hit.y, 8.0)
        rgb = _base(hit, bars, pattern.astype(np.float32))
        rgb[~bar] *= np.array((0.35, 0.4, 0.35), np.float32)
        return rgb, None

    return shade


def hedge(rng: np.random.Generator, grain: float) -> Shader:
    """Clipped or wild green."""
    base = colour(*((58, 84, 38), (72, 92, 46), (50, 72, 44))[rng.integers(3)])

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        a = _sideways(hit) + hit.x
        pattern = 1.0 + (0.35 + grain) * noise(a, hit.y + hit.z, 8.0)
        return _base(hit, base, pattern.astype(np.float32)), None

    return shade


def grass(rng: np.random.Generator, grain: float) -> Shader:
    """A verge, a median or a hill."""
    base = colour(*((104, 122, 62), (118, 124, 70), (90, 112, 58), (126, 112, 80))[rng.integers(4)])

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        fade = np.minimum(1.0, 12.0 / hit.depth)
        pattern = 1.0 + (0.08 + grain) * noise(hit.x, hit.z, 8.0) * fade + 0.12 * noise(hit.x, hit.z, 3.0)
        return _base(hit, base, pattern.astype(np.float32)), None

    return shade
