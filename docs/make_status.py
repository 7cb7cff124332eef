"""Bring the published cells' status and the pictures of docs/ up to date, from what the main job left in results/.

Run by `make status` after the main job; nothing is typed in by hand.
"""

import json
import shutil
import sys
from decimal import Decimal
from pathlib import Path

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.tables.published import TEST_SETS
from foggy_synscapes.tables.table import round_half_up

TITLES = {name: DATASETS[name].title for name in TEST_SETS}
NEEDS = {
    "C": "Cityscapes",
    "FC-498": "Cityscapes, Foggy Cityscapes",
    "FS-24500": "Cityscapes, Synscapes",
    "FS-498": "Cityscapes, Synscapes",
    "FC-FS-498": "Cityscapes, Foggy Cityscapes, Synscapes",
}
# The mean that the paper prints: over 19 classes, of which Foggy Zurich annotates 18.
PRINTED = "mean IoU as published"
PICTURES = ("beta_strip", "fc_against_fs", "sky_contrast")
"""Figures that pages of docs/ show."""


def number(text: str) -> str:
    """One decimal; `--` for what was not run."""
    return str(round_half_up(Decimal(text))) if text else "--"


def show(cell: dict[str, str]) -> str:
    """Published / ours; a class that the test set does not hold has neither."""
    return "-" if cell["ours"] == "-" else f"{number(cell['published'])} / {number(cell['ours'])}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))


def seeds(line: dict[str, str]) -> list[Decimal]:
    """Scores of each seed that was run."""
    return [Decimal(text) for key, text in line.items() if key.startswith("seed_") and text not in ("", "--", "-")]


def machine() -> str:
    """What the models were trained on, as their run records say."""
    records = [json.loads(path.read_text(encoding="utf-8")) for path in Path("results/train").glob("*/*/*/run.json")]
    found = set()
    for record in records:
        names = record["instructions"]["extensions"].split()
        widest = next((each for each in ("AVX512F", "AVX2", "AVX") if each in names), "no AVX")
        gpu = record.get("gpu", {}).get("name", "no GPU")
        found.add(
            f"{record['instructions']['machine']} with {widest}, {gpu}, PyTorch {record['versions']['torch']}, "
            f"Python {record['versions']['python']}"
        )
    return "; ".join(sorted(found))


def spread(lines: list[dict[str, str]]) -> str:
    """How far the seeds of a row lie apart, at most; what to make of it where there is one seed alone."""
    every = [scores for scores in map(seeds, lines) if scores]
    count = max(map(len, every), default=0)
    if count < 2:
        return (
            "One seed was run, so there is no spread over seeds and no interval: these scores rank no rows. "
            "`snakemake --cores 2 --configfile params/three_seeds.yaml` runs three."
        )
    widest = max(max(scores) - min(scores) for scores in every)
    return (
        f"Up to {count} seeds of a row were run; they lie up to {round_half_up(widest)} points of mean IoU apart. "
        "Rows whose intervals overlap are not ranked: [how to read the tables](tables.md)."
    )


def main() -> None:
    """Rewrite the page, and copy the pictures."""
    short: list[list[str]] = []
    whole: list[str] = []
    means = []
    for test_set, title in TITLES.items():
        lines = [line for line in read_csv(f"results/tables/{test_set}.csv") if line["row"] in NEEDS]
        scores = list(dict.fromkeys(line["score"] for line in lines))
        cells = {(line["network"], line["row"], line["score"]): line for line in lines}
        rows = []
        for network, row in dict.fromkeys((line["network"], line["row"]) for line in lines):
            mean = cells[network, row, PRINTED]
            means.append(mean)
            ours = number(mean["ours"])
            if mean["std"]:
                ours += f" ± {number(mean['std'])}"
            needed = f"{title}, {NEEDS[row]}"
            short.append([title, network, row, number(mean["published"]), ours, str(len(seeds(mean))), needed])
            pairs = (cells[network, row, score] for score in scores)
            rows.append([network, row, *(show(cell) for cell in pairs)])
        whole += ["", f"## {title}, class by class", "IoU in percent: published / stand-in.", ""]
        whole += [table(["model", "row", *scores], rows)]
    head = ["test set", "model", "row", "paper", "stand-in", "seeds", "to reproduce it you need"]
    page = [
        "# Status of every published cell",
        "",
        "Mean IoU in percent, as published and on stand-in data by the default params (`--`: not run). C is the",
        "baseline trained on Cityscapes; the other rows fine-tune it on Foggy Cityscapes (FC), Foggy Synscapes (FS) or",
        "both, on so many images. **Stand-in scores are no reproduction**: they say that the cell is computed, and are",
        "never to be compared with the paper.",
        "",
        f"Trained on: {machine()}. Other processors give other weights and so other scores",
        "([what can change bytes](reproducibility.md#what-was-measured)). " + spread(means),
        "",
        "Made by `make status` from `results`.",
        "",
        table(head, short),
    ]
    write_text("docs/status.md", "\n".join([*page, *whole]) + "\n")
    for name in PICTURES:
        shutil.copy(f"results/figures/{name}.png", f"docs/images/{name}.png")


if __name__ == "__main__":
    try:
        main()
    except FoggyError as error:
        sys.exit(str(error))
