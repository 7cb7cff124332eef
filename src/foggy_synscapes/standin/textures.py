"""Surfaces of what is built and grown: facades, roofs, pavings, walls, fences, hedges and grass.

Each maker draws a look once and returns a shader (see `canvas.Shader`).
"""

from collections.abc import Callable

import numpy as np

from foggy_synscapes.standin.canvas import RIGHT, TOP, Hit, Shader
from foggy_synscapes.standin.style import Style, colour, noise

GLASS = colour("222a32")

_FACADES = "964834 ac6242 c4b28e 96948e cec8b8 b09260 78846e 846858 6e7078 bea096"


def _patterned(base: np.ndarray, reach: float, pattern: Callable[[Hit, np.ndarray], np.ndarray]) -> Shader:
    # One colour times a pattern of the hits and of how much is left of fine texture, fading from `reach` metres on.
    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        fade = np.minimum(1.0, reach / hit.depth)
        return base * pattern(hit, fade).astype(np.float32)[:, None], None

    return shade


def _sideways(hit: Hit) -> np.ndarray:
    # Horizontal coordinate on an upright face: z on the sides, x on front and back.
    return np.where(hit.face <= RIGHT, hit.z, hit.x)


def facade(style: Style, height: float) -> Shader:
    """Windows in storeys on a coloured wall."""
    rng, grain, glare = style.rng, style.grain, style.weather.glare
    wall = style.pick(_FACADES) * np.float32(rng.uniform(0.8, 1.08))
    trim = colour("3c3a38") if rng.random() < 0.4 else np.minimum(wall * np.float32(1.25), 0.9)
    storey, bay = rng.uniform(2.8, 3.5), rng.uniform(2.0, 3.4)
    wide, tall = rng.uniform(0.22, 0.36), rng.uniform(0.26, 0.36)
    shop, phase = rng.random() < 0.35, rng.uniform(0, 8)
    brick = rng.random() < 0.5

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        a, b, fade = _sideways(hit), hit.y, np.minimum(1.0, 18.0 / hit.depth)
        pattern = 1.0 + grain * noise(a + phase, b, 9.0) * fade + 0.6 * grain * noise(a, b + phase, 4.0)
        if brick:
            pattern *= 1.0 - (0.03 + 0.4 * grain) * ((b * 6).astype(np.int32) & 1) * fade
        pattern *= 0.82 + 0.18 * np.minimum(1, b / 2.5)
        rgb = wall * pattern[:, None]
        a, b = (a + phase) / bay, b / storey
        column, row = np.floor(a), np.floor(b)
        u, v = np.abs(a - column - 0.5), np.abs(b - row - 0.52)
        frame = (u < wide + 0.04) & (v < tall + 0.04)
        pane = (u < wide) & (v < tall)
        if shop:
            ground = row == 0
            frame |= ground & (v < 0.42)
            pane = np.where(ground, (u < 0.45) & (v < 0.36), pane)
        below_roof = hit.y < height - 0.5
        rgb[frame & below_roof] = trim
        lively = noise(column * 7.0 + row * 3.0, row * 5.0 + column, 3.0)
        mirror = np.clip(0.45 * glare * (0.6 + lively) + 0.05 * grain, 0, 0.6).astype(np.float32)
        glass = GLASS * (1 - mirror[:, None]) + mirror[:, None] * colour("c8d6e2")
        rgb[pane & below_roof] = glass[pane & below_roof]
        rgb[hit.y > height - 0.35] *= np.float32(0.7)
        return rgb, None

    return shade


def plain(style: Style, codes: str, grain: float) -> Shader:
    """One of these colours with grain: roofs, bins."""
    base = style.pick(codes) * np.float32(style.rng.uniform(0.9, 1.1))

    def rough(hit: Hit, fade: np.ndarray) -> np.ndarray:
        near = grain * noise(hit.x + hit.y, hit.z - hit.y, 5.0) * fade
        return 1.0 + near + 0.6 * grain * noise(hit.x, hit.z + hit.y, 3.0)

    return _patterned(base, 14.0, rough)


def paving(style: Style) -> Shader:
    """Slabs or cobbles of a sidewalk with a lighter kerb."""
    base, grain = style.pick("8a8682 7c7a78 928a80"), style.grain
    slab = style.rng.uniform(0.4, 0.9)

    def slabs(hit: Hit, fade: np.ndarray) -> np.ndarray:
        u, v = hit.x / slab, hit.z / slab
        joint = ((u - np.floor(u)) < 0.1) | ((v - np.floor(v)) < 0.1)
        tone = noise(np.floor(u), np.floor(v))
        return 1.0 + grain * (0.9 * tone + 0.7 * noise(hit.x, hit.z, 11.0)) * fade - (0.1 + grain) * joint * fade

    top = _patterned(base, 8.0, slabs)

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        rgb, _ = top(hit)
        rgb[hit.face != TOP] *= np.float32(0.75)
        return rgb, None

    return shade


def masonry(style: Style) -> Shader:
    """A free-standing wall of concrete, stone or brick with a coping."""
    base = style.pick("98969c 807c82 926052 a8a096")
    block, course = style.rng.uniform(0.8, 1.6), style.rng.uniform(0.35, 0.6)

    def courses(hit: Hit, fade: np.ndarray) -> np.ndarray:
        a, row = _sideways(hit), np.floor(hit.y / course)
        u = a / block + 0.5 * (row % 2)
        joint = ((u - np.floor(u)) < 0.06) | ((hit.y / course - row) < 0.12)
        rough = noise(np.floor(u) + row * 13, row) + 0.6 * noise(a, hit.y, 7.0)
        return 1.0 + style.grain * rough * fade - 0.22 * joint * fade

    return _patterned(base, 20.0, courses)


def palings(style: Style) -> Shader:
    """A fence: bars or planks with rails before a dark ground."""
    bars, rng = style.pick("785c40 464c4a b0aaa0 546046"), style.rng
    pitch, fill, top = rng.uniform(0.35, 0.7), rng.uniform(0.35, 0.6), rng.uniform(0.0, 0.3)
    wood = _patterned(bars, 1.0, lambda hit, _: 1.0 + style.grain * noise(_sideways(hit), hit.y, 8.0))

    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        rgb, _ = wood(hit)
        u = _sideways(hit) / pitch
        bar = (u - np.floor(u) < fill) | (np.abs(hit.y - 0.25) < 0.07) | (np.abs(hit.y - 0.95 - top) < 0.07)
        rgb[~bar] *= np.array((0.35, 0.4, 0.35), np.float32)
        return rgb, None

    return shade


def hedge(style: Style) -> Shader:
    """Clipped or wild green."""
    base, grain = style.pick("3a5426 485c2e 32482c"), 0.35 + style.grain
    return _patterned(base, 1.0, lambda hit, _: 1.0 + grain * noise(_sideways(hit) + hit.x, hit.y + hit.z, 8.0))


def grass(style: Style) -> Shader:
    """A verge, a median or a hill."""
    base, grain = style.pick("687a3e 767c46 5a703a 7e7050"), 0.08 + style.grain

    def tufts(hit: Hit, fade: np.ndarray) -> np.ndarray:
        return 1.0 + grain * noise(hit.x, hit.z, 8.0) * fade + 0.12 * noise(hit.x, hit.z, 3.0)

    return _patterned(base, 12.0, tufts)
