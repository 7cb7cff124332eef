"""The measurements of networks as cells of tables; what was not measured prints `--`."""

from collections.abc import Sequence

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.numbers import DASH, MISSING, signed
from foggy_synscapes.tables.paper import TITLES
from foggy_synscapes.tables.results import NETWORKS
from foggy_synscapes.tradeoff.networks import Score, reference_of
from foggy_synscapes.tradeoff.training import Cost

COLUMNS = (
    "network", "scale", "way", "cpu_ms", "times_as_fast", "miou", "change", "most_changed_class",
    "largest_logit_change", "changed_percent", "pareto",
)  # fmt: skip
HEADS = (
    "Network",
    "Scale",
    "Way",
    "CPU ms",
    "Faster",
    "mIoU",
    "Change",
    "Most changed",
    "Logits",
    "Pixels (%)",
    "Front",
)
CLASS_COLUMNS = tuple(f"change {name}" for name in CLASSES)


def rows(scores: Sequence[Score], front: Sequence[bool], classes: bool = False) -> list[tuple[str, ...]]:
    """One row per way by `COLUMNS`, and by `CLASS_COLUMNS` if `classes`; changes in points of IoU."""
    return [
        _row(score, reference_of(scores, score.network), best, classes)
        for score, best in zip(scores, front, strict=True)
    ]


def _row(score: Score, plain: Score, best: bool, classes: bool) -> tuple[str, ...]:
    head = score.network, f"{score.scale:g}", score.way
    if score.cpu_ms is None:
        return *head, *[MISSING] * (len(COLUMNS) - 4), "", *[MISSING] * (len(CLASSES) if classes else 0)
    change = score.change(plain)
    most = max(change, key=lambda name: abs(change[name]))
    cells = (
        f"{score.cpu_ms:.1f}",
        f"{plain.cpu_ms / score.cpu_ms:.2f}",
        f"{score.miou:.2f}",
        signed(score.miou - plain.miou, 2),
        f"{most} {signed(change[most])}" if change[most] else "",
        f"{score.largest:.2g}",
        f"{score.changed:.3g}",
        "yes" if best else "",
    )
    each = [signed(change[name], 2) if name in change else DASH for name in CLASSES] if classes else []
    return *head, *cells, *each


def printed(cells: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Rows that begin with a network, with the name that people read."""
    return [(title(network), *rest) for network, *rest in cells]


def title(name: str) -> str:
    """What people call a network or a test set; the name itself where they have no other.

    >>> title("bisenet"), title("foggy_driving"), title("cityscapes")
    ('BiSeNet', 'Foggy Driving', 'cityscapes')
    """
    return {**NETWORKS, **TITLES}.get(name, name)


def cost_rows(costs: Sequence[Cost]) -> list[tuple[str, ...]]:
    """One row per fine-tuning, by `training.COLUMNS`."""
    return [
        (
            cost.network,
            cost.row,
            str(cost.images),
            str(cost.iterations),
            f"{cost.seconds:.3f}",
            f"{cost.minutes:.2f}",
            MISSING if cost.miou is None else f"{cost.miou:.2f}",
        )
        for cost in costs
    ]
