"""Tables as LaTeX, Markdown and HTML; what they look like stands in templates/."""

import functools
import re
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import jinja2
import pandas as pd

from foggy_synscapes.tables.table import DASH, MEAN, Table

_LATEX = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': "''", "`": r"\textasciigrave{}",
    "±": r"$\pm$", "−": "$-$", "Δ": r"$\Delta$", "β": r"$\beta$",
}  # fmt: skip
_MARKDOWN = {char: f"\\{char}" for char in "\\`*_[]<#|~"}


def escape_latex(text: str) -> str:
    r"""Text as LaTeX prints it: every special character is escaped, line ends and control characters become spaces; an
    arrow `->` becomes one.

    >>> print(escape_latex("50 % of A&B_1 #2 -> 3"))
    50 \% of A\&B\_1 \#2 $\to$ 3
    """
    return r"$\to$".join(_escaped(part, _LATEX) for part in text.split("->"))


def escape_markdown(text: str) -> str:
    r"""Text as Markdown prints it.

    >>> print(escape_markdown("a|b_c"))
    a\|b\_c
    """
    return _escaped(text, _MARKDOWN)


def _escaped(text: str, special: dict[str, str]) -> str:
    return "".join(special.get(char, char if char.isprintable() else " ") for char in text)


def latex(tables: Sequence[Table], about: str) -> str:
    """Tables as one file to `\\input`: booktabs rules, a block per network, heads turned by 90 degrees as in the paper.

    about : a comment at the top
    """
    return _render("tables.tex", tables=tables, about=about)


def markdown(tables: Sequence[Table]) -> str:
    """Tables for the README and for reading in a terminal: caption, pipe table with bold marks, notes."""
    return _render("tables.md", tables=tables)


def html(tables: Sequence[Table], title: str) -> str:
    """Tables as one page, for a browser and for Snakemake's report; means come first, the classes after them."""
    return _render("tables.html", pairs=[(table, _styled(table)) for table in tables], title=title)


def long_latex(frame: pd.DataFrame, caption: str, label: str) -> str:
    """A frame of text as a `longtable`, which may run over pages. Underscores of heads become spaces."""
    return _render("long.tex", frame=frame, caption=caption, label=label)


def long_markdown(frame: pd.DataFrame) -> str:
    """A frame of text as a pipe table, without a line end. Underscores of heads become spaces."""
    return _render("long.md", frame=frame).rstrip("\n")


def _cell(text: str, bold: bool) -> str:
    if text == DASH:
        return r"\multicolumn{1}{c}{-}"
    escaped = re.sub(r"^-(?=\d)", "$-$", escape_latex(text))
    return rf"\textbf{{{escaped}}}" if bold else escaped


def _head(text: str) -> str:
    """A head, in two lines where it has a comma; that of a mean is bold."""
    first, comma, second = map(escape_latex, text.partition(", "))
    first = rf"\textbf{{{first}}}" if text.startswith(MEAN) else first
    return rf"\shortstack[l]{{{first} \\ {second}}}" if comma else first


def _label_width(table: Table) -> float:
    """Width in em of the longest label with a number of images, which the paper sets flush right."""
    texts = [f"{label.fine_tuning} ({label.images})" for label in table.labels.itertuples() if label.images]
    return 0.52 * max(map(len, texts), default=0) + 0.3


def _groups(table: Table) -> list[tuple[str, int, int]]:
    """Groups of heads with their first and last column, counted from 1 with the three of the labels."""
    places = groupby(enumerate(table.heads, start=4), key=lambda column: column[1][0])
    spans = [(name, [place for place, _ in own]) for name, own in places]
    return [(name, own[0], own[-1]) for name, own in spans]


def _blocks(table: Table) -> list[tuple[str, list[tuple[Any, list[tuple[str, bool]]]]]]:
    """For each network its rows: their labels, and each cell with whether it is bold."""
    labels = table.labels.reset_index().itertuples()
    cells = (list(zip(*line, strict=True)) for line in zip(table.cells.to_numpy(), table.bold.to_numpy(), strict=True))
    lines = zip(labels, cells, strict=True)
    return [(network, list(own)) for network, own in groupby(lines, key=lambda line: line[0].network)]


def _styled(table: Table) -> str:
    names = {"network": "Model", "training": "Training", "fine_tuning": "Fine-Tuning", "images": "Images"}
    cells, bold = (
        frame.set_axis([f"{group}: {head}" if group else head for group, head in table.heads], axis=1)
        for frame in (table.cells, table.bold)
    )
    cells = table.labels.join(cells).set_index(list(table.labels), append=True).rename_axis(index=names)
    cells = cells[sorted(cells, key=lambda head: MEAN not in head)]
    marks = bold[list(cells)].set_axis(cells.index).map({True: "font-weight: bold", False: ""}.get)
    style = cells.style.format(escape="html").format_index(escape="html", axis=0).format_index(escape="html", axis=1)
    # Without a name of its own a table would get a random one, and the page other bytes each time.
    return style.apply(lambda _: marks, axis=None).set_uuid(table.name).to_html(doctype_html=False)


def _render(name: str, **values: Any) -> str:
    return _environment().get_template(name).render(**values)


@functools.cache
def _environment() -> jinja2.Environment:
    # Braces and percent signs are LaTeX's own.
    made = jinja2.Environment(
        loader=jinja2.PackageLoader("foggy_synscapes.tables"), autoescape=lambda name: str(name).endswith(".html"),
        block_start_string="<%", block_end_string="%>", comment_start_string="<#", comment_end_string="#>",
        variable_start_string="<<", variable_end_string=">>", undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    made.filters |= {"latex": escape_latex, "markdown": escape_markdown, "head": _head}
    made.globals |= {"cell": _cell, "groups": _groups, "blocks": _blocks, "label_width": _label_width}
    return made
