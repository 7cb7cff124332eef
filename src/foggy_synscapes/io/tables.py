"""Small CSV tables as text: the same rows give the same bytes everywhere."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text


def write_csv(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a header and rows, comma separated, with plain line feeds; None becomes an empty cell."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(["" if cell is None else cell for cell in row] for row in rows)
    write_text(path, buffer.getvalue())


def read_csv(path: str | Path, columns: Sequence[str] = ()) -> list[dict[str, str]]:
    """Read a table that has a header; every cell is text.

    Raises
    ------
    FoggyError
        If the file is missing or no UTF-8 text, a row is not as long as the header, or one of `columns` is not there.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.reader(file, strict=True)
            header = next(reader, [])
            lines = list(reader)
    except FileNotFoundError as error:
        raise FoggyError(f"{path}: missing. It is made by an earlier step: run `snakemake` or `dvc repro`.") from error
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FoggyError(f"{path}: not a readable CSV table: {error}") from error
    missing = [column for column in columns if column not in header]
    if missing:
        raise FoggyError(f"{path}: column {', '.join(missing)} missing; found {', '.join(header) or 'no header'}")
    for number, line in enumerate(lines, start=2):
        if len(line) != len(header):
            raise FoggyError(f"{path}, line {number}: {len(line)} cells, expected {len(header)}")
    return [dict(zip(header, line, strict=True)) for line in lines]
