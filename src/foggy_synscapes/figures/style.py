"""How all figures look, and how they become bytes that are the same every time."""

import io

import matplotlib
from matplotlib.figure import Figure

DPI = 150
"""Dots per inch of PNG figures; text and lines of PDF figures have none."""

# Okabe and Ito's palette, which readers with any kind of colour vision can tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# Lines differ in dashes as well as in colour, for print in black and white.
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (1, 1)))

SETTINGS = matplotlib.RcParams(
    {
        "font.size": 8,
        "axes.titlesize": 8,
        "axes.labelsize": 8,
        "legend.fontsize": 7,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "pdf.fonttype": 42,
        "svg.hashsalt": "foggy-synscapes",
        "image.interpolation": "nearest",
    }
)


def new_figure(width: float, height: float) -> Figure:
    """A figure of so many inches that lays itself out."""
    with matplotlib.rc_context(SETTINGS):
        return Figure(figsize=(width, height), layout="constrained")


def render(figure: Figure, ending: str) -> bytes:
    """Bytes of a figure as "png" or "pdf", without time stamps or versions of programs."""
    metadata = {"png": {"Software": None}, "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}[ending]
    buffer = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(buffer, format=ending, dpi=DPI, metadata=metadata)
    return buffer.getvalue()
