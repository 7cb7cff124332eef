"""Draw docs/images/published.svg, the means of the paper's two tables as a picture, from the published numbers.

Run by `make status`; a test holds the picture to the numbers. Equal numbers and versions give equal bytes.
"""

import io
from pathlib import Path

import matplotlib as mpl

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.figures.style import COLOURS, SETTINGS
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.tables import published
from foggy_synscapes.tables.table import MEAN

WIDTH, LINE = 7.2, 0.24
"""Width of the picture and height of a line, in inches."""
BAR = 22.0
"""How far a bar of 100 % would reach, in the unit of the table's columns."""
COLUMNS = {"foggy_driving": 33.0, "foggy_zurich": 53.0}
"""Where the bars of a test set begin; the table is 70 wide."""


def picture() -> bytes:
    """The table of means as SVG: a line for each network and row, a bar and a number for each test set."""
    mpl.use("svg")
    from matplotlib import pyplot as plt

    tables = {name: published.load(name) for name in COLUMNS}
    rows = tables["foggy_driving"]
    with mpl.rc_context({**SETTINGS, "svg.fonttype": "none", "font.size": 9}):
        figure = plt.figure(figsize=(WIDTH, LINE * (len(rows) + 2)))
        axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 72), ylim=(len(rows) + 1, -1))
        axes.axis("off")
        heads = {1.0: "network", 10.0: "trained on (images)"}
        heads |= {left: f"{DATASETS[name].title}, %" for name, left in COLUMNS.items()}
        for left, head in heads.items():
            axes.text(left, 0, head, va="center", fontweight="bold")
        axes.axhline(0.5, color="black", linewidth=0.8)
        for line, (network, row) in enumerate(rows.index, start=1):
            entry = rows.loc[network, row]
            images = f" ({int(entry['images']):,})" if entry["images"] else ""
            tuned = "" if entry["fine_tuning"] == "-" else f", then {entry['fine_tuning']}{images}"
            axes.text(1.0, line, network, va="center")
            axes.text(10.0, line, f"{entry['training']}{tuned}", va="center")
            for name, left in COLUMNS.items():
                means = tables[name][MEAN].loc[network]
                largest = means[row] == max(means)
                width = float(means[row]) / 100 * BAR
                axes.barh(line, width, 0.7, left, color=COLOURS[0] if largest else COLOURS[5])
                weight = "bold" if largest else "normal"
                axes.text(left + width + 0.5, line, str(means[row]), va="center", fontweight=weight)
            if line > 1 and network != rows.index[line - 2][0]:
                axes.axhline(line - 0.5, color="black", linewidth=0.4)
        axes.set_facecolor("white")
        drawn = io.BytesIO()
        figure.savefig(drawn, format="svg", facecolor="white", metadata={"Date": None})
        plt.close(figure)
    return drawn.getvalue()


if __name__ == "__main__":
    write_bytes(Path(__file__).parent / "images/published.svg", picture())
