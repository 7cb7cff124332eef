"""Narasimhan and Nayar's series for light scattered many times, as a negative result: why it is no rung of the ladder.

    I(T, mu) = sum over m >= 0 of (g_m + g_(m+1)) P_m(mu),  g_0 = 0,
    g_m = exp(-b_m T - a_m ln T),  a_m = m + 1,  b_m = (2 m + 1) (1 - q^(m - 1)) / m
T optical depth, q forward scattering, mu cosine to the source. For large m the ratio of terms is 1 / T: below T = 1,
which is all that lies nearer than a mean free path, the series diverges.
Source: Narasimhan and Nayar, Shedding Light on the Weather, CVPR 2003; g_0 as in its text.
"""

import math

import numpy as np

from foggy_synscapes.fog.radiance import encoded, linear

SHORTEST = 1.05
"""Optical depth to which nearer points are set: the nearest at which the series can be summed."""
TERMS, LAYERS, FORWARD = 300, 6, 0.9


def coefficients(depth: float, forward: float = FORWARD, terms: int = TERMS) -> np.ndarray:
    """g_0 to g_terms at an optical depth above 1: float64 (terms + 1,); ValueError where the series diverges.

    >>> float(coefficients(2.0)[1])                  # b_1 = 0: 1 / T^2
    0.25
    """
    if not depth > 1:
        raise ValueError(f"optical depth {depth:g}: the series diverges, expected above 1")
    m = np.arange(1, terms + 1, dtype=np.float64)
    rates = (2 * m + 1) / m * (1 - forward ** (m - 1))
    return np.concatenate([[0.0], np.exp(-rates * depth - (m + 1) * math.log(depth))])


def intensity(depth: float, cosine: np.ndarray, forward: float = FORWARD, terms: int = TERMS) -> np.ndarray:
    """I(T, mu), float64 of the shape of `cosine`."""
    g = coefficients(depth, forward, terms)
    return np.polynomial.legendre.legval(cosine, g[:-1] + g[1:])


def foggy(image: np.ndarray, distance: np.ndarray, beta: float, surround: np.ndarray, focal: float) -> np.ndarray:
    """Fog whose airlight is the scene spread by the series' kernel, uint8 (H, W, 3).

    image : uint8 (H, W, 3); distance : float64 (H, W), metres along the ray; surround : linear (3,); focal : pixels

    The kernel at an angle from the axis, I cos^3, is normalised over the sphere: what falls outside of the frame is the
    surround's. It is that of one optical depth for each of a few layers; nearer ones than SHORTEST are set there.
    """
    height, width = distance.shape
    depth = np.maximum(beta * distance, SHORTEST)
    edges = np.quantile(depth, np.linspace(0, 1, LAYERS + 1))
    t = np.exp(-beta * distance)[..., None]
    contrast = linear(image) - surround
    rows, columns = np.arange(-height + 1, height), np.arange(-width + 1, width)
    radius = np.sqrt(rows[:, None] ** 2 + columns[None, :] ** 2) / focal
    cosine = 1 / np.sqrt(1 + radius**2)
    size = 3 * height, 3 * width
    spectrum = np.fft.rfft2(contrast, size, axes=(0, 1))
    spread, which = np.zeros_like(contrast), np.clip(np.searchsorted(edges, depth, side="right") - 1, 0, LAYERS - 1)
    for layer in np.unique(which):
        here = which == layer
        middle = float(np.median(depth[here]))
        kernel = intensity(middle, cosine) * cosine**3 / focal**2 / (4 * math.pi * coefficients(middle)[1])
        whole = np.fft.irfft2(spectrum * np.fft.rfft2(kernel, size)[..., None], size, axes=(0, 1))
        spread[here] = whole[height - 1 : 2 * height - 1, width - 1 : 2 * width - 1][here]
    return np.rint(encoded(surround + t * contrast + (1 - t) * spread)).astype(np.uint8)
