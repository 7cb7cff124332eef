"""The paper's Tables I and II, made anew from their published numbers."""

import pandas as pd

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.published import mean_of_classes
from foggy_synscapes.tables.table import DASH, HEADS, LABELS, MEAN, Table, best, images_text, round_half_up, rounded

ABBREVIATIONS = "C = Cityscapes, FC = Foggy Cityscapes, FS = Foggy Synscapes"


def published_table(test_set: str, rows: pd.DataFrame) -> Table:
    """One published table, cell for cell, with its means checked in the notes."""
    numbers = rows[[*CLASSES, MEAN]]
    return Table(
        name=f"{test_set}_results",
        caption=f"Test results on {DATASETS[test_set].title}, as published: IoU in percent. {ABBREVIATIONS}",
        labels=rows[LABELS].assign(images=rows["images"].map(_images)),
        cells=numbers.astype(str).where(numbers.notna(), DASH).rename(columns=HEADS),
        bold=best(rounded(numbers)),
        notes=notes(rows),
    )


def published_csv(rows: pd.DataFrame) -> str:
    """The same table as CSV, with the recomputed means and the source lines."""
    recomputed = {
        f"recomputed mean over {text}": mean_of_classes(rows, annotated).map(lambda mean: round_half_up(mean, 2))
        for text, annotated in (("19", False), ("annotated", True))
    }
    rows = rows.assign(**recomputed, **{"annotated classes": rows[list(CLASSES)].count(axis=1)}).reset_index()
    rows = rows.drop(columns=["row", "label_line"]).rename(columns={"network": "model", "value_line": "source line"})
    lines = rows.pop("source line")
    return rows.assign(**{"source line": lines}).to_csv(index=False, na_rep=DASH, lineterminator="\n")


def notes(rows: pd.DataFrame) -> list[str]:
    """What recomputing the means from the printed classes shows: their convention, and where they differ."""
    absent = [name for name in CLASSES if rows[name].isna().all()]
    recomputed = mean_of_classes(rows, annotated=False)
    odd = rows[recomputed.map(round_half_up) != rows[MEAN]]
    head = "Means recomputed from the printed classes: "
    if absent:
        head += f"the printed means divide by 19, with {', '.join(absent)} counted as 0. "
        means = mean_of_classes(rows, annotated=True).map(round_half_up).astype(str)
        blocks = [f"{network} {', '.join(own)}" for network, own in means.groupby(level="network", sort=False)]
        known = len(CLASSES) - len(absent)
        head += f"Over the {known} annotated classes they are, from top to bottom, {'; '.join(blocks)}."
    else:
        head += "the printed means are those over all 19 classes."
    if odd.empty:
        return [f"{head} All {len(rows)} agree to the last digit."]
    cases = [
        f"{key[0]} {row['fine_tuning']} ({_images(row['images'])}): "
        f"{round_half_up(recomputed[key], 2)} recomputed, {row[MEAN]} printed"
        for key, row in odd.iterrows()
    ]
    agree = f"{len(rows) - len(odd)} of {len(rows)} agree to the last digit"
    return [head, f"{agree}; the others differ by the rounding of the classes: {'; '.join(cases)}."]


def _images(text: str) -> str:
    return images_text(int(text) if text else None, None)
