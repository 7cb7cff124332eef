"""Tables of the runs made here: in the paper's form, against the paper, and as one long CSV."""

import pandas as pd

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.numbers import DASH, MISSING, signed
from foggy_synscapes.tables.paper import ABBREVIATIONS
from foggy_synscapes.tables.results import ANNOTATED, AS_PUBLISHED, MEANS, Results
from foggy_synscapes.tables.table import HEADS, MEAN, Table, best, rounded

STAND_IN = (
    "All images are the rendered stand-in, not the real datasets: compare rows with each other, not with the paper."
)


def tables(test_set: str, results: Results, annotated: list[str] | None, stand_in: bool) -> list[Table]:
    """The table of our runs in the paper's form and, for a published test set, the tables against the paper."""
    data = f"{DATASETS[test_set].title}{' (stand-in)' if stand_in else ''}"
    conventions = {
        ANNOTATED: "annotated" if annotated is None else f"{len(annotated)} annotated",
        AS_PUBLISHED: "19 as published",
    }
    heads = HEADS | {name: f"{MEAN}, {text}" for name, text in conventions.items()}
    notes = _notes(annotated, results, stand_in)
    cells, numbers = _ours(results)
    ours = Table(
        name=f"{test_set}_ours",
        caption=f"Results on {data} of the runs made here: IoU in percent. {ABBREVIATIONS}",
        labels=results.labels,
        cells=cells.rename(columns=heads),
        bold=best(numbers),
        notes=notes,
    )
    published = results.wide("published")
    if published.isna().all(axis=None):
        return [ours]
    notes = notes + _other_ground_truth(annotated, published)
    paper = rounded(published[MEANS])
    differences = _differences(results)
    beside = {
        "paper": (paper.map("{:.1f}".format).where(paper.notna(), MISSING), paper),
        "ours": (cells[MEANS], numbers[MEANS]),
        "difference": (differences[MEANS].replace(DASH, MISSING), paper * float("nan")),
    }
    order = [(name, head) for name in MEANS for head in beside]
    means = Table(
        name=f"{test_set}_means",
        caption=f"Mean IoU on {data} in percent: the paper, the runs made here, and their difference. {ABBREVIATIONS}",
        labels=results.labels,
        cells=pd.DataFrame({(conventions[name], head): beside[head][0][name] for name, head in order}),
        bold=best(pd.DataFrame({(conventions[name], head): beside[head][1][name] for name, head in order})),
        notes=notes,
        upright=True,
    )
    difference = Table(
        name=f"{test_set}_difference",
        caption=f"Difference on {data}, the runs made here minus the paper: IoU in points of percent. {ABBREVIATIONS}",
        labels=results.labels,
        cells=differences.rename(columns=heads),
        bold=pd.DataFrame(False, index=differences.index, columns=differences.columns),
        notes=notes,
    )
    return [ours, means, difference]


def long_csv(test_set: str, results: Results) -> str:
    """One line per network, row and score, unrounded; see `docs/tables.md`."""
    made = results.made.loc[results.scores.index.droplevel("score")].set_axis(results.scores.index)
    scores = results.scores.astype(object)
    for column in (*made.columns, "ours"):
        here = made[column] if column in made else made.any(axis=1)
        scores[column] = scores[column].where(scores[column].notna(), DASH).where(here, MISSING)
    scores["difference"] = scores["difference"].where(made.any(axis=1), MISSING)
    # Of one seed there is no deviation.
    numbers = scores[["published", "ours", "std", "difference", *made.columns]].reset_index("score")
    lines = results.labels.join(numbers.rename(columns={seed: f"seed_{seed}" for seed in made}), how="right")
    lines = lines.reset_index()
    lines.insert(0, "test_set", test_set)
    return lines.to_csv(index=False, lineterminator="\n")


def means(results: Results) -> dict[str, dict[str, float]]:
    """Mean IoU over the annotated classes by network and row, where it was run: what `dvc metrics` compares."""
    found: dict[str, dict[str, float]] = {}
    for (network, row), mean in results.wide("ours")[ANNOTATED].dropna().items():
        found.setdefault(network, {})[row] = mean
    return found


def _ours(results: Results) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Our scores as printed, and as numbers: NaN where there are none."""
    numbers, spread = rounded(results.wide("ours")), rounded(results.wide("std")[MEANS])
    cells = numbers.map("{:.1f}".format).where(numbers.notna(), DASH)
    cells[MEANS] = cells[MEANS].where(spread.isna(), cells[MEANS] + " ± " + spread.map("{:.1f}".format))
    return cells.where(results.made.any(axis=1), MISSING, axis=0), numbers


def _differences(results: Results) -> pd.DataFrame:
    """Ours minus published as printed; a class that our ground truth does not hold has a dash."""
    differences, undefined = results.wide("difference"), results.wide("ours").isna()
    cells = differences.map(signed, na_action="ignore").astype(object)
    return cells.where(differences.notna(), MISSING).mask(undefined.mul(results.made.any(axis=1), axis=0), DASH)


def _notes(annotated: list[str] | None, results: Results, stand_in: bool) -> list[str]:
    made, seeds = results.made, list(results.made.columns)
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
    if not made.any(axis=1).all():
        notes.append(f"{MISSING}: not run.")
    partial = made[made.any(axis=1) & ~made.all(axis=1)]
    if not partial.empty:
        names = [f"{' '.join(key)} ({count} of {len(seeds)})" for key, count in partial.sum(axis=1).items()]
        notes.append(f"Fewer seeds than asked for: {', '.join(names)}.")
    return notes


def _other_ground_truth(annotated: list[str] | None, published: pd.DataFrame) -> list[str]:
    """A note where the paper's ground truth has other classes than the one here."""
    known = {name for name in CLASSES if published[name].notna().any()}
    if annotated is None or known == set(annotated):
        return []
    return [f"The paper's column is over its own {len(known)} annotated classes."]
