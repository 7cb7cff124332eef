"""A table as Markdown, for the README and for reading in a terminal."""

from foggy_synscapes.tables.grid import Cell, Grid, Line

_SPECIAL = "\\`*_[]<#|~"


def escape(text: str) -> str:
    r"""Text as Markdown prints it.

    >>> print(escape("a|b_c"))
    a\|b\_c
    """
    shown = "".join(char if char.isprintable() else " " for char in text)
    return "".join(f"\\{char}" if char in _SPECIAL else char for char in shown)


def table(grid: Grid) -> str:
    """Caption, a pipe table with bold marks, and the notes."""
    heads = [f"{head.group}: {head.text}" if head.group else head.text for head in grid.heads]
    lines = [
        escape(grid.caption),
        "",
        _row(["Model", "Training", "Fine-Tuning (# of images)", *heads]),
        "|" + "---|" * 3 + "---:|" * len(heads),
    ]
    for block in grid.blocks:
        for line in block.lines:
            lines.append("| " + " | ".join([escape(block.network), *_labels(line), *map(_cell, line.cells)]) + " |")
    for note in grid.notes:
        lines += ["", escape(note)]
    return "\n".join([*lines, ""])


def _labels(line: Line) -> list[str]:
    images = f" ({line.images})" if line.images else ""
    return [escape(line.training), escape(line.fine_tuning + images)]


def _row(texts: list[str]) -> str:
    return "| " + " | ".join(map(escape, texts)) + " |"


def _cell(cell: Cell) -> str:
    return f"**{cell.text}**" if cell.bold else cell.text
