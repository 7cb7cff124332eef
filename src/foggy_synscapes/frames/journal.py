"""What was made of each frame in a folder, by content: one line per image, each with a checksum.

Lines are appended as images are finished, and sorted when a run ends. A line that a kill cut off, or that was changed,
does not count: its image is made again.
"""

import csv
import io
import os
import zlib
from collections.abc import Mapping
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames.finding import order
from foggy_synscapes.frames.folders import Made
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import LARGEST_TABLE, named, read_bytes

NAME = "made.csv"
COLUMNS = ("id", "image", "sha256", "made_of", "red", "green", "blue", "row", "column", "check")


def begin(folder: Path) -> dict[str, Made]:
    """What is known by frame id, of a frame whose inputs changed what was made last; to be called before `append`.

    No other run may be at its beginning or end here meanwhile. Raises FoggyError if the table is no plain file.
    """
    path = folder / NAME
    known = read(folder)
    if not os.path.lexists(path):
        _append(path, ",".join(COLUMNS) + "\n")
    elif not read_bytes(path, limit=LARGEST_TABLE).endswith(b"\n"):
        _append(path, "\n")  # ends what a kill cut off
    return known


def read(folder: Path) -> dict[str, Made]:
    """The same, without a beginning."""
    path = folder / NAME
    if not os.path.lexists(path):
        return {}
    known: dict[str, Made] = {}
    with named(path, "table of what was made", "Delete it; all images are made again then."):
        for line in read_bytes(path, limit=LARGEST_TABLE).decode("utf-8", "replace").splitlines():
            text, _, check = line.rpartition(",")
            if check != _check(text):
                continue
            frame, image, digest, of, *light = next(csv.reader([text]))
            if frame not in known or known[frame].of != of:
                red, green, blue, row, column = map(int, light)
                known[frame] = Made(of, (red, green, blue, row, column), {})
            if image:
                known[frame].images[image] = digest
    return known


def append(folder: Path, frame: str, made: Made) -> None:
    """Write down what was made of a frame; FoggyError if that fails."""
    _append(folder / NAME, _lines(frame, made))


def finish(folder: Path, found: Mapping[str, Made]) -> dict[str, Made]:
    """Sort what is known, with what this run found, and return it; another run may have begun or ended meanwhile."""
    known = {**read(folder), **found}
    lines = (_lines(frame, known[frame]) for frame in sorted(known, key=order))
    write_text(folder / NAME, ",".join(COLUMNS) + "\n" + "".join(lines))
    return known


def _lines(frame: str, made: Made) -> str:
    lines = ""
    for image, digest in sorted(made.images.items()) or [("", "")]:
        buffer = io.StringIO()
        csv.writer(buffer, lineterminator="").writerow((frame, image, digest, made.of, *made.light))
        lines += f"{buffer.getvalue()},{_check(buffer.getvalue())}\n"
    return lines


def _append(path: Path, text: str) -> None:
    # In one write, at the end of the file wherever that is by now: another run may be at work in the same folder.
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
        try:
            os.write(descriptor, text.encode())
        finally:
            os.close(descriptor)
    except OSError as error:
        raise FoggyError(f"{path}: cannot be written: {error.strerror}. Check space and permissions.") from error


def _check(text: str) -> str:
    return f"{zlib.crc32(text.encode()):08x}"
