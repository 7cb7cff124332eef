"""Run DVC, after a kill too: `make repro`, or `python workflow/repro.py [options of dvc repro]`.

DVC writes two files of its own in place, dvc.lock and .dvc/tmp/rwlock. A kill at that moment leaves half of one, and
`dvc repro` then refuses to start. Here such a file is mended first: of dvc.lock the steps that are whole are kept (what
the others made is in DVC's run cache), and rwlock, which says who reads and writes at the moment, begins anew.
"""

import json
import os
import sys
from pathlib import Path

from dvc.cli import main as dvc
from dvc.exceptions import DvcException
from dvc.lock import make_lock
from dvc.repo import Repo
from dvc.rwlock import RWLOCK_FILE, RWLOCK_LOCK, SCHEMA
from dvc.schema import COMPILED_LOCKFILE_SCHEMA
from dvc.utils.serialize import YAMLFileCorruptedError, parse_yaml
from voluptuous import Invalid

from foggy_synscapes import params
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import remove_leftovers, write_bytes

LOCK = Path("dvc.lock")
HEAD = b"  "  # of the line that begins a step; lines inside a step are indented further


def is_whole(data: bytes) -> bool:
    """Whether DVC takes this for a lock file.

    >>> is_whole(b"schema: '2.0'\\nstages:\\n  filter:\\n    cmd: foggy filter\\n"), is_whole(b"schema: '2.0'\\nsta")
    (True, False)
    """
    try:
        COMPILED_LOCKFILE_SCHEMA(parse_yaml(data.decode(), LOCK))
    except (YAMLFileCorruptedError, Invalid, UnicodeDecodeError):
        return False
    return True


def whole_part(data: bytes) -> bytes:
    """A lock file, or where it is torn the steps before the one that was being written; nothing where there is none.

    >>> whole_part(b"schema: '2.0'\\nstages:\\n  filter:\\n    cmd: foggy filter\\n  fog:\\n    cmd: fo")
    b"schema: '2.0'\\nstages:\\n  filter:\\n    cmd: foggy filter\\n"
    """
    if is_whole(data):
        return data
    lines = data.splitlines(keepends=True)
    for end in range(len(lines) - 1, 0, -1):
        begins = lines[end].startswith(HEAD) and not lines[end].startswith(HEAD + b" ")
        if begins and is_whole(part := b"".join(lines[:end])):
            return part
    return b""


def mend(repo: Repo) -> list[str]:
    """Mend what a kill tore of DVC's own files, while no other DVC is at work on them; the names of those mended."""
    mended = []
    with repo.lock:
        if LOCK.is_file() and not is_whole(data := LOCK.read_bytes()):
            part = whole_part(data)
            write_bytes(LOCK.resolve(), part) if part else LOCK.unlink()
            mended.append(str(LOCK))
        locks = Path(repo.tmp_dir, RWLOCK_FILE)
        with make_lock(str(locks.with_name(RWLOCK_LOCK)), tmp_dir=repo.tmp_dir):
            if locks.is_file() and not _says_who_reads(locks):
                locks.unlink()
                mended.append(str(locks.relative_to(repo.root_dir)))
    return mended


def _says_who_reads(path: Path) -> bool:
    try:
        SCHEMA(json.loads(path.read_bytes()))
    except (ValueError, Invalid):
        return False
    return True


def main(options: list[str]) -> int:
    """Mend, then run `dvc repro` with these options; its exit status.

    The params are checked before DVC reads them, which puts their values into shell lines.
    """
    try:
        repo = Repo()
        os.chdir(repo.root_dir)
        params.load("params.yaml")
        os.environ[lock.HELD] = "dvc"  # its jobs, should they outlive it, are then waited for, not taken for a run
        with lock.hold():
            remove_leftovers("results")
            for name in mend(repo):
                print(f"repro: {name} was torn by a kill; it is mended", file=sys.stderr)
            return dvc(["repro", *options])
    except (DvcException, FoggyError) as error:
        print(f"repro: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
