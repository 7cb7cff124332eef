"""Training curves."""

from typing import TYPE_CHECKING

from foggy_synscapes.figures.figure import CURVES, RUNS, Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources


def draw(sources: "Sources") -> "Drawing":
    """One column per network, one line per row."""
    from foggy_synscapes.figures.losses import losses

    return losses(
        {
            title: {row: sources.curves(network, row) for row in sources.rows}
            for network, title in sources.networks.items()
        }
    )


FIGURE = Figure(
    text="Losses over each training, first seed. The dot is the snapshot with the lowest validation "
    "loss, which is kept.",
    inputs=(CURVES,),
    keys=RUNS,
    draw=draw,
)
