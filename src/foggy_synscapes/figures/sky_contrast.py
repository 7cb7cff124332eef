"""Distribution of the scene key by which the paper would filter, and the filter's cut."""

from typing import TYPE_CHECKING

from foggy_synscapes.figures.figure import FILTER, Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources

KEY = "sky_contrast"


def draw(sources: "Sources") -> "Drawing":
    """The key is that of the paper's section IV.B."""
    from foggy_synscapes.figures.histogram import cut_histogram

    values, kept = sources.filter(KEY)
    cuts = [
        (kind, getattr(rule, kind))
        for rule in sources.params.filter.rules
        for kind in ("minimum", "maximum")
        if rule.key == KEY and getattr(rule, kind) is not None
    ]
    stand_in = " (stand-in)" if sources.drawn("synscapes") else ""
    return cut_histogram(values, kept, cuts, KEY, f"Synscapes{stand_in}: contrast of the sky of each frame")


FIGURE = Figure(
    text="Contrast of the sky over all frames of Synscapes. Values of 5 to 6 are direct sun, which the "
    "filter may leave out.",
    inputs=(FILTER,),
    keys=("filter", "scenes.roots"),
    draw=draw,
)
