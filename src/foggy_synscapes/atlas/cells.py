"""What the reference is made of: a frame, how dense the fog is, how it scatters, and what surrounds the frame."""

from dataclasses import asdict, dataclass

OPEN, GROUND, SKY = "open", "ground", "sky"
SURROUNDS = (OPEN, GROUND, SKY)
"""What lies outside of the frame: open: the airlight from all sides; ground: below the horizon a plane of the frame's
mean road; sky: from all sides the mean radiance of the frame's sky instead of the estimated airlight."""

FRAMES, SEED, SIZE = 8, 2019, (128, 256)
"""How many frames of the stand-in, their seed, and their rows and columns."""
BETAS = (0.005, 0.02, 0.06)
"""1/m: the thinnest and the densest fog of the paper (section III), and one between."""
ALBEDO, ASYMMETRY = 1.0, 0.85
"""Of fog: droplets absorb no visible light, and scatter forward (mean cosine; van de Hulst 1957)."""
SIDE_FRAMES, SIDE_BETA = 1, 0.02


@dataclass(frozen=True)
class Cell:
    """One case of the reference.

    frame : number of the stand-in's frame; beta : 1/m, at the road; surround : one of SURROUNDS
    albedo : share of the extinguished light that is scattered; asymmetry : mean cosine of Henyey and Greenstein
    height : metres over which the fog thins to a share 1/e; 0: homogeneous

    Raises ValueError where one is out of its range.
    """

    frame: int
    beta: float
    surround: str = OPEN
    albedo: float = ALBEDO
    asymmetry: float = ASYMMETRY
    height: float = 0.0

    def __post_init__(self) -> None:
        for name, right, range_ in (
            ("beta", self.beta > 0, "above 0"),
            ("surround", self.surround in SURROUNDS, f"{OPEN}, {GROUND} or {SKY}"),
            ("albedo", 0 <= self.albedo <= 1, "0 to 1"),
            ("asymmetry", -1 < self.asymmetry < 1, "between -1 and 1"),
            ("height", self.height >= 0, "0 (homogeneous) or above"),
        ):
            if not right:
                raise ValueError(f"{name}: {getattr(self, name)!r}, expected {range_}")

    @property
    def name(self) -> str:
        """A key for files.

        >>> Cell(3, 0.02).name
        '3-0.02-open-1-0.85-0'
        """
        return "-".join(value if isinstance(value, str) else f"{value:g}" for value in asdict(self).values())

    @property
    def is_core(self) -> bool:
        """Whether it differs from others by frame, beta and surround only."""
        same = (self.albedo, self.asymmetry, self.height) == (ALBEDO, ASYMMETRY, 0.0)
        return same and self.surround != SKY


def cells() -> list[Cell]:
    """All cases: the core of every frame, beta and surround, then single changes of the first frames."""
    core = [
        Cell(frame, beta, surround)
        for frame in range(FRAMES)
        for beta in (BETAS[1], BETAS[0], BETAS[2])
        for surround in (OPEN, GROUND)
    ]
    changes: list[dict] = [
        {"surround": SKY},
        *({"asymmetry": asymmetry} for asymmetry in (0.0, 0.5, 0.95)),
        *({"albedo": albedo} for albedo in (0.95, 0.8)),
        *({"height": height} for height in (5.0, 20.0)),
    ]
    return core + [Cell(frame, SIDE_BETA, **change) for change in changes for frame in range(SIDE_FRAMES)]
