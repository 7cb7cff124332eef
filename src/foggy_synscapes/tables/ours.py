"""Tables of the runs made here: in the paper's form, against the paper, and as one long CSV."""

from collections.abc import Sequence
from decimal import Decimal

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.grid import HEADS, Block, Cell, Grid, Head, Line, marked
from foggy_synscapes.tables.numbers import DASH, MISSING, round_half_up, signed
from foggy_synscapes.tables.paper import ABBREVIATIONS
from foggy_synscapes.tables.paper import TITLES as PUBLISHED_TITLES
from foggy_synscapes.tables.results import ANNOTATED, AS_PUBLISHED, NAMES, Result, Score

TITLES = {**PUBLISHED_TITLES, "cityscapes": "clear Cityscapes validation"}
STAND_IN = (
    "All images are the rendered stand-in, not the real datasets: compare rows with each other, not with the paper."
)


def grids(
    test_set: str, results: list[Result], annotated: list[str] | None, seeds: Sequence[str], stand_in: bool
) -> list[Grid]:
    """The table of our runs in the paper's form and, for a published test set, the tables against the paper."""
    data = f"{TITLES[test_set]}{' (stand-in)' if stand_in else ''}"
    number = len(annotated) if annotated is not None else None
    notes = _notes(annotated, results, seeds, stand_in)
    heads = [Head(HEADS.get(name, name)) for name in CLASSES] + _mean_heads(number)
    ours = Grid(
        name=f"{test_set}_ours",
        caption=f"Results on {data} of the runs made here: IoU in percent. {ABBREVIATIONS}",
        heads=heads,
        blocks=_blocks(results, _our_cells),
        notes=notes,
    )
    if all(score.published is None for result in results for score in result.scores.values()):
        return [ours]
    notes = notes + _other_ground_truth(annotated, results)
    means = Grid(
        name=f"{test_set}_means",
        caption=f"Mean IoU on {data} in percent: the paper, the runs made here, and their difference. {ABBREVIATIONS}",
        heads=[
            Head(head, group=group)
            for group in (_convention(number), "19 as published")
            for head in ("paper", "ours", "difference")
        ],
        blocks=_blocks(results, _mean_cells),
        notes=notes,
        upright=True,
    )
    difference = Grid(
        name=f"{test_set}_difference",
        caption=f"Difference on {data}, the runs made here minus the paper: IoU in points of percent. {ABBREVIATIONS}",
        heads=heads,
        blocks=_blocks(results, _difference_cells),
        notes=notes,
    )
    return [ours, means, difference]


def long_columns(test_set: str, results: list[Result], seeds: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Columns and rows of the CSV: one row per network, row and score, unrounded; see `docs/tables.md`."""
    columns = ["test_set", "network", "row", "training", "fine_tuning", "images", "score"]
    columns += ["published", "ours", "spread", "difference", *(f"seed_{seed}" for seed in seeds)]
    table = []
    for result in results:
        label = result.label
        labels = [test_set, result.network, label.row, label.training, label.fine_tuning, label.images_text]
        for name in NAMES:
            score = result.scores[name]
            published = "" if score.published is None else str(score.published)
            runs = iter(score.runs)
            per_seed = [_number(next(runs)) if made else MISSING for made in result.made]
            ours = _number(score.mean) if any(result.made) else MISSING
            difference = MISSING if not any(result.made) else "" if score.difference is None else repr(score.difference)
            spread = "" if score.spread is None else repr(score.spread)
            table.append([*labels, name, published, ours, spread, difference, *per_seed])
    return columns, table


def means(results: list[Result]) -> dict[str, dict[str, float]]:
    """Mean IoU over the annotated classes by network and row, where it was run: what `dvc metrics` compares."""
    found: dict[str, dict[str, float]] = {}
    for result in results:
        mean = result.scores[ANNOTATED].mean
        if mean is not None:
            found.setdefault(result.network, {})[result.label.row] = mean
    return found


def _number(value: float | None) -> str:
    return DASH if value is None else repr(value)


def _convention(annotated: int | None) -> str:
    return "annotated" if annotated is None else f"{annotated} annotated"


def _mean_heads(annotated: int | None) -> list[Head]:
    return [Head(f"mean IoU, {_convention(annotated)}", bold=True), Head("mean IoU, 19 as published", bold=True)]


def _notes(annotated: list[str] | None, results: list[Result], seeds: Sequence[str], stand_in: bool) -> list[str]:
    notes = [STAND_IN] if stand_in else []
    if annotated is not None:
        absent = [name for name in CLASSES if name not in annotated]
        without = f" (not {', '.join(absent)})" if absent else ""
        notes.append(
            f"{len(annotated)} annotated: mean over the classes of this ground truth{without}; "
            "19 as published: absent classes count as 0."
        )
    if len(seeds) > 1:
        notes.append(f"Mean over seeds {', '.join(seeds)}; ± is their standard deviation.")
    if not all(any(result.made) for result in results):
        notes.append(f"{MISSING}: not run.")
    partial = [r for r in results if any(r.made) and not all(r.made)]
    if partial:
        names = [f"{r.network} {r.label.row} ({sum(r.made)} of {len(r.made)})" for r in partial]
        notes.append(f"Fewer seeds than asked for: {', '.join(names)}.")
    return notes


def _other_ground_truth(annotated: list[str] | None, results: list[Result]) -> list[str]:
    """A note where the paper's ground truth has other classes than the one here."""
    published = {name for r in results for name in CLASSES if r.scores[name].published is not None}
    if annotated is None or published == set(annotated):
        return []
    return [f"The paper's column is over its own {len(published)} annotated classes."]


def _blocks(results: list[Result], cells) -> list[Block]:
    blocks = []
    for network in dict.fromkeys(result.network for result in results):
        own = [result for result in results if result.network == network]
        lines = zip(own, cells(own), strict=True)
        blocks.append(
            Block(
                network, [Line(r.label.training, r.label.fine_tuning, r.label.images_text, line) for r, line in lines]
            )
        )
    return blocks


def _our_cells(results: list[Result]) -> list[list[Cell]]:
    values = [[_rounded(result.scores[name].mean) for name in NAMES] for result in results]
    texts = [
        [_text(result, result.scores[name], spread=name in (ANNOTATED, AS_PUBLISHED)) for name in NAMES]
        for result in results
    ]
    return marked(values, texts)


def _mean_cells(results: list[Result]) -> list[list[Cell]]:
    values, texts = [], []
    for result in results:
        numbers, printed = [], []
        for name in (ANNOTATED, AS_PUBLISHED):
            score = result.scores[name]
            paper = None if score.published is None else round_half_up(score.published)
            numbers += [paper, _rounded(score.mean), None]
            printed += [MISSING if paper is None else str(paper), _text(result, score, spread=True), _difference(score)]
        values.append(numbers)
        texts.append(printed)
    return marked(values, texts)


def _difference_cells(results: list[Result]) -> list[list[Cell]]:
    return [
        [
            Cell(DASH if any(result.made) and result.scores[name].mean is None else _difference(result.scores[name]))
            for name in NAMES
        ]
        for result in results
    ]


def _difference(score: Score) -> str:
    return MISSING if score.difference is None else signed(score.difference)


def _text(result: Result, score: Score, spread: bool) -> str:
    if not any(result.made):
        return MISSING
    if score.mean is None:
        return DASH
    text = str(_rounded(score.mean))
    return f"{text} ± {round_half_up(score.spread)}" if spread and score.spread is not None else text


def _rounded(value: float | None) -> Decimal | None:
    return None if value is None else round_half_up(value)
