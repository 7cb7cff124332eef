"""Any rows of text as a table: in LaTeX one that may run over several pages, or in Markdown."""

from collections.abc import Sequence

from foggy_synscapes.tables import markdown
from foggy_synscapes.tables.latex import escape


def long_table(columns: Sequence[str], rows: Sequence[Sequence[str]], caption: str, label: str) -> str:
    """One `longtable` environment; needs the packages booktabs and longtable. Underscores of heads become spaces."""
    head = " & ".join(rf"\textbf{{{escape(column.replace('_', ' '))}}}" for column in columns) + r" \\"
    lines = [
        r"% Needs \usepackage{booktabs,longtable}",
        r"{\scriptsize\setlength{\tabcolsep}{3pt}",
        rf"\begin{{longtable}}{{{'l' * len(columns)}}}",
        rf"\caption{{{escape(caption)}}}\label{{{label}}}\\",
        r"\toprule",
        head,
        r"\midrule",
        r"\endfirsthead",
        r"\toprule",
        head,
        r"\midrule",
        r"\endhead",
        r"\bottomrule",
        r"\endfoot",
        *(" & ".join(map(escape, row)) + r" \\" for row in rows),
        r"\end{longtable}}",
    ]
    return "\n".join([*lines, ""])


def pipe_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """One Markdown table. Underscores of heads become spaces."""
    lines = [[column.replace("_", " ") for column in columns], *rows]
    cells = ["| " + " | ".join(markdown.escape(cell) for cell in line) + " |" for line in lines]
    return "\n".join([cells[0], "|" + "---|" * len(columns), *cells[1:]])
