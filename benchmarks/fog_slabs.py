"""Path tracing against discrete ordinates: light reflected and transmitted by slabs of fog.

Writes src/foggy_synscapes/atlas/slabs.csv, which the tests compare. Needs the extra `reference`:
    pip install "foggy-synscapes[reference]"; python benchmarks/fog_slabs.py

A slab of optical depth tau, Henyey-Greenstein scattering of mean cosine 0.85, no absorption, lit by radiance 1 from
every direction above, black below. Radiance is taken at the cosine mu to its normal.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from foggy_synscapes.atlas.pathtracing import NO_ROULETTE, mitsuba

OUT = Path(__file__).resolve().parents[1] / "src/foggy_synscapes/atlas/slabs.csv"
ASYMMETRY, ALBEDO = 0.85, 1 - 1e-6
DEPTHS, COSINES = (0.5, 1.0, 3.0), (0.9, 0.5, 0.2)
STREAMS, PATHS, SEEDS = 32, 4_096, 16
WIDE, FAR = 1000.0, 1e6


def ordinates(depth: float, cosines: list[float]) -> np.ndarray:
    """Reflected and transmitted radiance, (2, N), the direct light included in the latter."""
    from PythonicDISORT import subroutines
    from PythonicDISORT.pydisort import pydisort

    moments = ASYMMETRY ** np.arange(STREAMS + 1)
    found = pydisort(
        np.array([depth]), np.array([ALBEDO]), STREAMS, moments[None, :], 0.5, 0.0, 0.0, b_neg=1.0, NFourier=1
    )
    radiance = subroutines.interpolate(found[-1])
    up, down = (
        [float(np.squeeze(radiance(sign * mu, at, 0.0))) for mu in cosines] for sign, at in ((1, 0.0), (-1, depth))
    )
    return np.array([up, down])


def traced(depth: float, cosine: float, reflected: bool) -> tuple[float, float]:
    """The same by path tracing: mean and standard error over seeds."""
    library = mitsuba()
    from mitsuba import ScalarTransform4f as Transform

    sine = np.sqrt(1 - cosine**2)
    # Off the diagonals of the slab's faces, where edges of triangles leak.
    across = np.array([np.cos(0.6), 0.0, np.sin(0.6)]) * sine
    height = depth / 2 + 0.5
    towards = np.array([0.0, -cosine, 0.0]) + across if reflected else np.array([0.0, cosine, 0.0]) + across
    origin = np.array([0.37, height if reflected else -height, 0.23])
    phase = {"type": "hg", "g": ASYMMETRY}
    unit, albedo = ({"type": "rgb", "value": [value] * 3} for value in (1.0, ALBEDO))
    fog = {"type": "homogeneous", "sigma_t": unit, "albedo": albedo, "phase": phase, "sample_emitters": False}
    sky = Transform().translate([0, 100, 0]).rotate([1, 0, 0], 90).scale([FAR, FAR, 1])
    loaded = library.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": NO_ROULETTE},
            "slab": {
                "type": "cube",
                "to_world": Transform().scale([WIDE, depth / 2, WIDE]),
                "bsdf": {"type": "null"},
                "interior": fog,
            },
            "sky": {
                "type": "rectangle",
                "to_world": sky,
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1.0] * 3}},
            },
            "sensor": {
                "type": "radiancemeter",
                "origin": origin.tolist(),
                "direction": towards.tolist(),
                "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent"},
            },
        }
    )
    found = [float(np.array(library.render(loaded, spp=PATHS, seed=seed))[0, 0, 0]) for seed in range(SEEDS)]
    return float(np.mean(found)), float(np.std(found, ddof=1) / np.sqrt(SEEDS))


def main() -> None:
    lines = []
    for depth in DEPTHS:
        exact = ordinates(depth, list(COSINES))
        for way, name in enumerate(("reflected", "transmitted")):
            for place, cosine in enumerate(COSINES):
                mean, error = traced(depth, cosine, name == "reflected")
                lines.append((depth, cosine, name, round(exact[way, place], 6), round(mean, 6), round(error, 6)))
                print(*lines[-1], round((mean - exact[way, place]) / error, 2), flush=True)
    table = pd.DataFrame(lines, columns=["depth", "cosine", "light", "ordinates", "traced", "standard_error"])
    table.to_csv(OUT, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
