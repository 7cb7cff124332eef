"""The measurements of networks as tables; what was not measured prints `--`."""

from collections.abc import Sequence

import pandas as pd

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import titles
from foggy_synscapes.tables.numbers import DASH, MISSING, signed
from foggy_synscapes.tradeoff.networks import Score, reference_of
from foggy_synscapes.tradeoff.training import Cost

# Columns of the CSV files, and their heads where people read them; those without a head are in the CSV file alone.
BACKENDS = {
    "network": "Network",
    "scale": "Scale",
    "way": "Way",
    "cpu_ms": "CPU ms",
    "times_as_fast": "Faster",
    "miou": "mIoU",
    "change": "Change",
    "most_changed_class": "Most changed",
    "largest_logit_change": "Logits",
    "changed_percent": "Pixels (%)",
    "pareto": "Front",
}
COSTS = {
    "network": "Network",
    "row": "Row",
    "images": "Images",
    "iterations": "Iterations",
    "cpu_seconds_per_iteration": "CPU s per iteration",
    "cpu_minutes": "CPU minutes",
    "miou": "mIoU",
}
CLASS_COLUMNS = [f"change {name}" for name in CLASSES]


def backends(scores: Sequence[Score], front: Sequence[bool]) -> pd.DataFrame:
    """One line of text per backend, by `BACKENDS` and `CLASS_COLUMNS`; changes in points of IoU."""
    lines = [_line(score, reference_of(scores, score.network)) for score in scores]
    table = pd.DataFrame(lines, columns=[*BACKENDS, *CLASS_COLUMNS], dtype=object).fillna(MISSING)
    return table.assign(pareto=["yes" if best else "" for best in front])


def costs(measured: Sequence[Cost]) -> pd.DataFrame:
    """One line of text per fine-tuning, by `COSTS`."""
    lines = [
        (
            cost.network,
            cost.row,
            str(cost.images),
            str(cost.iterations),
            f"{cost.seconds:.3f}",
            f"{cost.minutes:.2f}",
            MISSING if cost.miou is None else f"{cost.miou:.2f}",
        )
        for cost in measured
    ]
    return pd.DataFrame(lines, columns=list(COSTS))


def printed(table: pd.DataFrame, heads: dict[str, str]) -> pd.DataFrame:
    """The columns of a table that have heads, under these, with the names of networks that people read."""
    return table[list(heads)].assign(network=table["network"].map(title)).rename(columns=heads)


def title(name: str) -> str:
    """What people call a network or a test set.

    >>> title("bisenet"), title("foggy_driving")
    ('BiSeNet', 'Foggy Driving')
    """
    return DATASETS[name].title if name in DATASETS else titles()[name]


def _line(score: Score, plain: Score) -> dict[str, str]:
    line = {"network": score.network, "scale": f"{score.scale:g}", "way": score.way}
    if score.cpu_ms is None:
        return line
    change = score.change(plain)
    most = max(change, key=lambda name: abs(change[name]))
    return line | {
        "cpu_ms": f"{score.ms:.1f}",
        "times_as_fast": f"{plain.ms / score.ms:.2f}",
        "miou": f"{score.miou:.2f}",
        "change": signed(score.miou - plain.miou, 2),
        "most_changed_class": f"{most} {signed(change[most])}" if change[most] else "",
        "largest_logit_change": f"{score.largest:.2g}",
        "changed_percent": f"{score.changed:.3g}",
        **{f"change {name}": signed(change[name], 2) if name in change else DASH for name in CLASSES},
    }
