"""Bring the published cells' status up to date: README.md and docs/status.md, from the tables in results/.

Run by `make status` after the main job; nothing is typed in by hand.
"""

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

START, END = "<!-- status -->", "<!-- end of status -->"
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


def number(text: str) -> str:
    """One decimal; `--` for what was not run."""
    return str(round_half_up(Decimal(text))) if text else "--"


def show(cell: dict[str, str]) -> str:
    """Published / ours; a class that the test set does not hold has neither."""
    return "-" if cell["ours"] == "-" else f"{number(cell['published'])} / {number(cell['ours'])}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))


def main() -> None:
    """Rewrite both files and the picture of the README."""
    short: list[list[str]] = []
    whole = ["# Status of every published cell", ""]
    whole += [
        "IoU in percent: published / on stand-in data by the default `params.yaml` (`--`: not run). Every cell needs",
        "its test set and the training data that the README names beside its row. Stand-in scores are no reproduction:",
        "they say that the cell is computed. Made by `make status` from `results/tables`.",
    ]
    for test_set, title in TITLES.items():
        lines = [line for line in read_csv(f"results/tables/{test_set}.csv") if line["row"] in NEEDS]
        scores = list(dict.fromkeys(line["score"] for line in lines))
        cells = {(line["network"], line["row"], line["score"]): line for line in lines}
        rows = []
        for network, row in dict.fromkeys((line["network"], line["row"]) for line in lines):
            mean = cells[network, row, PRINTED]
            needed = f"{title}, {NEEDS[row]}"
            short.append([title, network, row, number(mean["published"]), number(mean["ours"]), needed])
            pairs = (cells[network, row, score] for score in scores)
            rows.append([network, row, *(show(cell) for cell in pairs)])
        whole += ["", f"## {title}", table(["model", "row", *scores], rows)]
    write_text("docs/status.md", "\n".join(whole) + "\n")
    head = ["test set", "model", "row", "paper", "stand-in", "to reproduce it you need"]
    readme = Path("README.md").read_text(encoding="utf-8")
    before, after = readme.split(START)[0], readme.split(END)[1]
    write_text("README.md", f"{before}{START}\n{table(head, short)}\n{END}{after}")
    Path("docs/images").mkdir(exist_ok=True)
    shutil.copy("results/figures/beta_strip.png", "docs/images/beta_strip.png")


if __name__ == "__main__":
    try:
        main()
    except FoggyError as error:
        sys.exit(str(error))
