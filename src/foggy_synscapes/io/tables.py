"""Small CSV tables as text: the same rows give the same bytes everywhere."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import LARGEST_TABLE, named, read_bytes

_ADVICE = "It is made by an earlier step: run `snakemake` or `dvc repro`."


def write_csv(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a header and rows as `csv_text` gives them."""
    write_text(path, csv_text(columns, rows))


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A header and rows, comma separated, with plain line feeds; None becomes an empty cell."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(["" if cell is None else cell for cell in row] for row in rows)
    return buffer.getvalue()


class GrowingTable:
    """A table for people to watch: a row is in the file as soon as it is added. What was there before is gone."""

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("w", encoding="utf-8", newline="")
        self.add(columns)

    def add(self, row: Sequence[Any]) -> None:
        """Add a row; None becomes an empty cell."""
        csv.writer(self._file, lineterminator="\n").writerow("" if cell is None else cell for cell in row)
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_csv(path: str | Path, columns: Sequence[str] = ()) -> list[dict[str, str]]:
    """Read a table that has a header; every cell is text.

    Raises
    ------
    FoggyError
        If the file is missing, no UTF-8 text or larger than 1 GiB, a row is not as long as the header, a column stands
        there twice, or one of `columns` is not there.
    """
    with named(path, "CSV table", _ADVICE):
        text = read_bytes(path, "CSV table", _ADVICE, LARGEST_TABLE).decode("utf-8")
        try:
            header, *lines = csv.reader(io.StringIO(text, newline=""), strict=True) if text else [[]]
        except csv.Error as error:
            raise ValueError(error) from error
    missing = [column for column in columns if column not in header]
    if missing or len(set(header)) != len(header):
        wrong = f"column {', '.join(missing)} missing" if missing else "a column stands twice"
        raise FoggyError(f"{path}: {wrong}; found {', '.join(header) or 'no header'}")
    for number, line in enumerate(lines, start=2):
        if len(line) != len(header):
            raise FoggyError(f"{path}, line {number}: {len(line)} cells, expected {len(header)}")
    return [dict(zip(header, line, strict=True)) for line in lines]
