"""A table before it becomes text: blocks of rows under column heads, and what stands around them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal

from foggy_synscapes.tables.numbers import best

# The paper's heads; other classes are headed by their names.
HEADS = {"traffic light": "tr.light", "traffic sign": "tr.sign"}


@dataclass(frozen=True)
class Cell:
    """Text of a cell, and whether it is bold."""

    text: str
    bold: bool = False


@dataclass(frozen=True)
class Line:
    """A row: what was trained on, what it was fine-tuned on, with how many images, and its cells."""

    training: str
    fine_tuning: str
    images: str
    cells: list[Cell]


@dataclass(frozen=True)
class Block:
    """The rows of one network."""

    network: str
    lines: list[Line]


@dataclass(frozen=True)
class Head:
    """A column: its head, whether that is bold, and the group of columns that it stands in."""

    text: str
    bold: bool = False
    group: str = ""


@dataclass(frozen=True)
class Grid:
    """A whole table. `upright` heads are printed level, others turned by 90 degrees."""

    name: str
    caption: str
    heads: list[Head]
    blocks: list[Block]
    notes: list[str] = field(default_factory=list)
    upright: bool = False


def marked(rows: Sequence[Sequence[Decimal | None]], texts: Sequence[Sequence[str]]) -> list[list[Cell]]:
    """Cells of one block with its bold marks: `rows` has the printed numbers, `texts` what is printed for them."""
    columns = [best(column) for column in zip(*rows, strict=True)]
    return [
        [Cell(text, column[number]) for text, column in zip(line, columns, strict=True)]
        for number, line in enumerate(texts)
    ]
