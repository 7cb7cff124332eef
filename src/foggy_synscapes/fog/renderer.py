"""What the inner loops of fog need besides a frame: constants of its betas, and memory for a row."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from foggy_synscapes.fog.kernel import BLOCK, GROUP, LOG2E, F, U, render, square, transmittances

MARGINS = {1: 3, 2: 4, 4: 7}
"""Units by which v is taken too high, by the number of factors of t: then a sample that may lie on the other side of a
step has a fraction below twice as many."""
# 1/m: within, float32 errs as the kernel says; what it takes for infinitely far lies behind an optical depth of 34.
LOWEST_BETA, HIGHEST_BETA = 1e-37, 1e37
HALF_UP, UNIT = 256.5, 2.0**-15  # the kernel computes 256.5 + F, and counts in this unit there


def _factors(betas: np.ndarray) -> list[int]:
    """Of how many exponentials each transmittance is the product; more than 1: the square of the one before."""
    factors: list[int] = []
    for b, beta in enumerate(betas):
        twice = b > 0 and betas[b - 1] > LOWEST_BETA and math.isclose(beta, 2 * betas[b - 1], rel_tol=1e-12)
        factors.append(2 * factors[-1] if twice and 2 * factors[-1] in MARGINS else 1)
    return factors


def exponentials(betas: Sequence[float], distance: np.ndarray) -> Iterator[tuple[float, int, np.ndarray]]:
    """Transmittance as rendering computes it before it composites: beta, number of factors, float32 (n,).

    betas : 1/m, ascending, from LOWEST_BETA to HIGHEST_BETA; distance : float32 (n,), metres
    """
    t = np.empty(distance.size, F)
    for beta, factors in zip(betas, _factors(np.array(betas, float)), strict=True):
        if factors > 1:
            square(t, 0, t.size)
        else:
            transmittances(distance, F(beta * -LOG2E), 0, t.size, t)
        yield beta, factors, t.copy()


def _aligned(shape: tuple[int, ...], kind: type) -> np.ndarray:
    """Memory whose vectors lie within one line of the processor's cache each: others take twice as long to load."""
    size = math.prod(shape) * np.dtype(kind).itemsize
    memory = np.empty(size + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    return memory[begin : begin + size].view(kind).reshape(shape)


class Renderer:
    """Fog at each beta on rows of images of one width, geometry and airlight; it owns the memory for one row.

    columns, scale : distance = depth sqrt((row + columns[x]) / scale), float64 (W,) and a number
    betas : float64 (B,), 1/m, at least 0; airlight : uint8 (3,)
    """

    def __init__(self, columns: np.ndarray, scale: float, betas: np.ndarray, airlight: np.ndarray) -> None:
        order = np.argsort(betas, kind="stable")
        betas, factors = betas[order], _factors(betas[order])
        margins = np.array([MARGINS[number] for number in factors], U)
        light = airlight.astype(F)
        plain = (betas < LOWEST_BETA) | (betas > HIGHEST_BETA)
        exponents = (np.where(plain, 0, betas) * -LOG2E).astype(F)
        bases = (light + HALF_UP + UNIT * margins[:, None]).astype(F)
        # Rows are of whole groups: behind their end lies the airlight, infinitely far away.
        groups = -(-columns.size // GROUP)
        wide = groups * GROUP
        floats, levels = _aligned((5, wide), F), _aligned((3, wide), np.uint8)
        distance, t, differences = floats[0], floats[1], floats[2:]
        distance[:], differences[:] = np.inf, 0
        nearest = np.empty(groups, F)
        self._row = distance, nearest, t, differences, levels
        self._constants = (
            (columns, scale, (columns / scale).astype(F)),
            (order, betas, plain, exponents, np.array(factors, int) > 1, bases, 2 * margins),
            (airlight, light),
            np.empty(wide // BLOCK + 1, np.int64),
        )

    def render(self, image: np.ndarray, depth: np.ndarray, rows: np.ndarray, out: np.ndarray, filtered: bool) -> None:
        """Fog on one image, or some of its rows.

        image : uint8 (H, W, 3); depth : float32 (H, W), metres; rows : float64 (H,), of the distance's formula
        out : uint8 (B, n), written: pixels, or where `filtered` scan lines of PNG with the filter Sub, 1 + 3 W each
        """
        flat = image.reshape(len(rows), -1)  # the compiler sees the step of 3, and takes whole vectors
        render(flat, depth, rows, out, filtered, self._row, *self._constants)
