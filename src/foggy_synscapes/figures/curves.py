"""Training curves."""

from foggy_synscapes.figures.figure import CURVES, RUNS, Drawing, Figure, Sources
from foggy_synscapes.figures.style import COLOURS, DASHES, drawing


def draw(sources: Sources) -> Drawing:
    """Training losses above, validation losses below; a column per network, a line per row."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    networks = sources.networks
    with drawing(3.6 * len(networks), 4.6) as figure:
        axes = figure.subplots(2, len(networks), squeeze=False, sharex=True)
        for (training, validation), (network, title) in zip(axes.T, networks.items(), strict=True):
            for number, row in enumerate(sources.rows):
                colour, dashes = COLOURS[number % len(COLOURS)], DASHES[number % len(DASHES)]
                losses = sources.curves(network, row)
                for panel, points in zip((training, validation), losses, strict=True):
                    line = zip(*points, strict=True) if points else ([], [])
                    panel.plot(*line, label=row, color=colour, linestyle=dashes, linewidth=1.1)
                if losses[1]:
                    best = min(losses[1], key=lambda point: point[1])
                    validation.plot(*best, "o", color=colour, markersize=4)
            training.set_title(title)
            validation.set_xlabel("training done (%); dot: the snapshot that is kept")
        for panel, name in zip(axes[:, 0], ("training loss", "validation loss"), strict=True):
            panel.set_ylabel(name)
        for panel in axes.flat:
            panel.set_yscale("log")
            # Plain numbers at every tick: losses stay within a decade or two.
            panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            panel.yaxis.set_minor_formatter(NullFormatter())
            panel.yaxis.set_major_locator(LogLocator(subs=(1, 1.2, 1.5, 2, 3, 4, 5, 6, 8)))
            panel.grid()
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


FIGURE = Figure(
    text="Losses over each training, first seed. The dot is the snapshot with the lowest validation "
    "loss, which is kept.",
    inputs=(CURVES,),
    keys=RUNS,
    draw=draw,
)
