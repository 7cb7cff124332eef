"""A table as LaTeX: booktabs rules, one block per network, heads turned by 90 degrees as in the paper."""

import re
from itertools import groupby

from foggy_synscapes.tables.grid import Block, Cell, Grid, Head, Line
from foggy_synscapes.tables.numbers import DASH

_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': "''", "`": r"\textasciigrave{}",
    "±": r"$\pm$", "−": "$-$", "Δ": r"$\Delta$", "β": r"$\beta$",
}  # fmt: skip
_SIGNED = re.compile(r"-(?=\d)")


def escape(text: str) -> str:
    r"""Text as LaTeX prints it: every special character is escaped, line ends and control characters become spaces; an
    arrow `->` becomes one.

    >>> print(escape("50 % of A&B_1 #2 -> 3"))
    50 \% of A\&B\_1 \#2 $\to$ 3
    """
    parts = (
        "".join(_SPECIAL.get(char, char if char.isprintable() else " ") for char in part) for part in text.split("->")
    )
    return r"$\to$".join(parts)


def table(grid: Grid) -> str:
    """One `table*` environment. It needs the packages booktabs, graphicx and multirow."""
    lines = [
        r"\begin{table*}[!htbp]",
        r"\centering",
        # As in the paper, a table that is wider than the text is shrunk to its width.
        r"\footnotesize\resizebox{\ifdim\width>\textwidth\textwidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{rrl*{{{len(grid.heads)}}}{{r}}}}",
        r"\toprule",
        *_heads(grid),
    ]
    for block in grid.blocks:
        lines += [r"\midrule", *_block(block, _label_width(grid))]
    lines += [
        r"\bottomrule",
        r"\end{tabular}}",
        rf"\caption{{{escape(grid.caption)}}}",
        rf"\label{{table:{grid.name}}}",
    ]
    if grid.notes:
        text = " ".join(map(escape, grid.notes))
        lines += [r"\smallskip", rf"\begin{{minipage}}{{\textwidth}}\footnotesize {text}\end{{minipage}}"]
    return "\n".join([*lines, r"\end{table*}", ""])


def document(grids: list[Grid], about: str) -> str:
    """Several tables as one file to `\\input`, with a comment that says what it needs."""
    head = [f"% {about}", r"% Needs \usepackage{booktabs,graphicx,multirow}", ""]
    return "\n".join([*head, "\n".join(table(grid) for grid in grids)])


def _heads(grid: Grid) -> list[str]:
    labels = [Head("Model"), Head("Training"), Head("Fine-Tuning" if grid.upright else "Fine-Tuning, (# of images)")]
    cells = [_stacked(head) for head in [*labels, *grid.heads]]
    if grid.upright:
        cells[3:] = [rf"\multicolumn{{1}}{{c}}{{{cell}}}" for cell in cells[3:]]
    else:
        cells = [rf"\rotatebox[origin=l]{{90}}{{{cell}}}" for cell in cells]
    groups = [(name, len(list(heads))) for name, heads in groupby(grid.heads, key=lambda head: head.group)]
    above, rules, at = [], [], 4
    for name, span in groups:
        above.append(rf"\multicolumn{{{span}}}{{c}}{{{escape(name)}}}")
        if name:
            rules.append(rf"\cmidrule(lr){{{at}-{at + span - 1}}}")
        at += span
    grouped = [" & & & " + " & ".join(above) + r" \\", " ".join(rules)] if rules else []
    return [*grouped, " & ".join(cells) + r" \\"]


def _stacked(head: Head) -> str:
    """A head, in two lines where it has a comma."""
    first, comma, second = head.text.partition(", ")
    text = _strong(escape(first), head.bold)
    return rf"\shortstack[l]{{{text} \\ {escape(second)}}}" if comma else text


def _block(block: Block, width: float) -> list[str]:
    first = rf"\multirow{{{len(block.lines)}}}{{*}}{{\rotatebox[origin=c]{{90}}{{{escape(block.network)}}}}}"
    return [first, *(_line(line, width) for line in block.lines)]


def _line(line: Line, width: float) -> str:
    label = escape(line.fine_tuning)
    if line.images:
        # The number of images is set flush right, as in the paper, in a box as wide as the longest label.
        label = rf"\makebox[{width:.1f}em][l]{{{label} \hfill ({escape(line.images)})}}"
    return f"& {escape(line.training)} & {label} & " + " & ".join(_cell(cell) for cell in line.cells) + r" \\"


def _label_width(grid: Grid) -> float:
    texts = [f"{line.fine_tuning} ({line.images})" for block in grid.blocks for line in block.lines if line.images]
    return 0.52 * max(map(len, texts), default=0) + 0.3


def _cell(cell: Cell) -> str:
    if cell.text == DASH:
        return r"\multicolumn{1}{c}{-}"
    return _strong(_SIGNED.sub("$-$", cell.text) if _SIGNED.match(cell.text) else escape(cell.text), cell.bold)


def _strong(text: str, bold: bool) -> str:
    return rf"\textbf{{{text}}}" if bold else text
