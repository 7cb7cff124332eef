"""The paper's Tables I and II, made anew from their published numbers."""

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.grid import HEADS, Block, Grid, Head, Line, marked
from foggy_synscapes.tables.numbers import DASH, count, round_half_up
from foggy_synscapes.tables.published import MEAN, PublishedRow

TITLES = {"foggy_driving": "Foggy Driving", "foggy_zurich": "Foggy Zurich-test"}
ABBREVIATIONS = "C = Cityscapes, FC = Foggy Cityscapes, FS = Foggy Synscapes"


def published_grid(test_set: str, rows: list[PublishedRow]) -> Grid:
    """One published table, cell for cell, with its means checked in the notes."""
    blocks = []
    for network in dict.fromkeys(row.network for row in rows):
        own = [row for row in rows if row.network == network]
        values = [[*row.iou.values(), row.mean] for row in own]
        texts = [[DASH if value is None else str(value) for value in line] for line in values]
        cells = marked(values, texts)
        lines = [Line(row.training, row.fine_tuning, _images(row), line) for row, line in zip(own, cells, strict=True)]
        blocks.append(Block(network, lines))
    return Grid(
        name=f"{test_set}_results",
        caption=f"Test results on {TITLES[test_set]}, as published: IoU in percent. {ABBREVIATIONS}",
        heads=[Head(HEADS.get(name, name)) for name in CLASSES] + [Head(MEAN, bold=True)],
        blocks=blocks,
        notes=notes(rows),
    )


def published_columns(rows: list[PublishedRow]) -> tuple[list[str], list[list[str]]]:
    """The same table as columns and rows of a CSV, with the recomputed means and the source lines."""
    columns = ["model", "training", "fine_tuning", "images", *CLASSES, MEAN]
    columns += ["recomputed mean over 19", "recomputed mean over annotated", "annotated classes", "source line"]
    table = []
    for row in rows:
        values = [DASH if value is None else str(value) for value in row.iou.values()]
        means = [str(round_half_up(row.mean_of_classes(annotated), 2)) for annotated in (False, True)]
        known = sum(value is not None for value in row.iou.values())
        labels = [row.network, row.training, row.fine_tuning, "" if row.images is None else str(row.images)]
        table.append([*labels, *values, str(row.mean), *means, str(known), str(row.value_line)])
    return columns, table


def notes(rows: list[PublishedRow]) -> list[str]:
    """What recomputing the means from the printed classes shows: their convention, and where they differ."""
    known = [name for name, value in rows[0].iou.items() if value is not None]
    absent = [name for name in CLASSES if name not in known]
    odd = [row for row in rows if round_half_up(row.mean_of_classes(annotated=False)) != row.mean]
    head = "Means recomputed from the printed classes: "
    if absent:
        head += f"the printed means divide by 19, with {', '.join(absent)} counted as 0. "
        means = []
        for network in dict.fromkeys(row.network for row in rows):
            own = [round_half_up(row.mean_of_classes(annotated=True)) for row in rows if row.network == network]
            means.append(f"{network} {', '.join(map(str, own))}")
        head += f"Over the {len(known)} annotated classes they are, from top to bottom, {'; '.join(means)}."
    else:
        head += "the printed means are those over all 19 classes."
    if not odd:
        return [f"{head} All {len(rows)} agree to the last digit."]
    cases = [
        f"{row.network} {row.fine_tuning} ({_images(row)}): "
        f"{round_half_up(row.mean_of_classes(annotated=False), 2)} recomputed, {row.mean} printed"
        for row in odd
    ]
    agree = f"{len(rows) - len(odd)} of {len(rows)} agree to the last digit"
    return [head, f"{agree}; the others differ by the rounding of the classes: {'; '.join(cases)}."]


def _images(row: PublishedRow) -> str:
    return "" if row.images is None else count(row.images)
