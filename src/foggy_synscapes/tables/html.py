"""A table as a page of HTML, for a browser and for Snakemake's report."""

from collections.abc import Sequence
from html import escape as escape_markup

from foggy_synscapes.tables.grid import Block, Cell, Grid, Line

# No script, font or picture from elsewhere: the page is whole by itself.
STYLE = """
body { font: 12px sans-serif; margin: 1em; color: #111; }
figure { margin: 0 0 2.5em; overflow-x: auto; }
figcaption { font-weight: bold; margin-bottom: 0.7em; }
table { border-collapse: collapse; border: solid; border-width: 2px 0; font-variant-numeric: tabular-nums; }
th, td { padding: 0.2em 0.4em; text-align: right; white-space: nowrap; }
th { font-weight: normal; vertical-align: bottom; }
thead th.turned { writing-mode: vertical-rl; transform: rotate(180deg); text-align: left; vertical-align: top; }
th[scope=row] { text-align: left; vertical-align: top; }
tbody { border-top: 1px solid; }
tbody tr:hover { background: #eee; }
p { max-width: 60em; margin: 0.4em 0; color: #444; }
"""


def escape(text: str) -> str:
    """Text as a browser shows it; an arrow `->` becomes one.

    >>> escape("A & B -> 3")
    'A &amp; B → 3'
    """
    return escape_markup(text.replace("->", "→"))


def document(grids: Sequence[Grid], title: str) -> str:
    """Several tables as one page."""
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    body = "\n".join(map(table, grids))
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def table(grid: Grid) -> str:
    """One table with its caption above and its notes below.

    >>> print(table(Grid("scores", "IoU < 100", [], [])))
    <figure><figcaption>IoU &lt; 100</figcaption>
    <table><thead>
    <tr><th scope="col">Model</th><th scope="col">Training</th><th scope="col">Fine-Tuning (# of images)</th></tr>
    </thead>
    </table>
    </figure>
    """
    heads = [(text, False) for text in ("Model", "Training", "Fine-Tuning (# of images)")]
    heads += [(f"{head.group}: {head.text}" if head.group else head.text, not grid.upright) for head in grid.heads]
    lines = [
        f"<figure><figcaption>{escape(grid.caption)}</figcaption>",
        "<table><thead>",
        f"<tr>{''.join(_head(text, turned) for text, turned in heads)}</tr>",
        "</thead>",
        *(line for block in grid.blocks for line in _block(block)),
        "</table>",
        *(f"<p>{escape(note)}</p>" for note in grid.notes),
        "</figure>",
    ]
    return "\n".join(lines)


def _head(text: str, turned: bool) -> str:
    return f'<th scope="col"{" class=turned" if turned else ""}>{escape(text)}</th>'


def _block(block: Block) -> list[str]:
    network = f'<th scope="row" rowspan="{len(block.lines)}">{escape(block.network)}</th>'
    rows = [_row(line, network if number == 0 else "") for number, line in enumerate(block.lines)]
    return ["<tbody>", *rows, "</tbody>"]


def _row(line: Line, network: str) -> str:
    images = f" ({line.images})" if line.images else ""
    labels = "".join(f'<th scope="row">{escape(text)}</th>' for text in (line.training, line.fine_tuning + images))
    return f"<tr>{network}{labels}{''.join(map(_cell, line.cells))}</tr>"


def _cell(cell: Cell) -> str:
    text = escape(cell.text)
    return f"<td>{f'<b>{text}</b>' if cell.bold else text}</td>"
