"""Content hashes that are known without reading: of files whose size, times and inode are those of the last time.

What is known belongs to the machine and lies outside of the results; without it, files are read. A stamp that differs
says nothing but that the file has to be read: copies, moved disks and touched files are then found equal.
"""

import json
import time
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256

CACHE = Path(".foggy/cache")
"""What only saves time, and knows the times of this machine's files: not a result."""
SETTLED_NS, COARSE_NS = 50_000_000, 2_000_000_000
"""Age in ns of the last change from which a stamp is trusted; the second where times are not finer than ms."""


def stamp(file: str | Path) -> list[int]:
    """Size in bytes, times of modification and of change in ns, and inode; empty where the file is missing."""
    try:
        status = Path(file).stat()
    except OSError:
        return []
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]


class Stamps:
    """SHA-256 by file, kept in a JSON file.

    path : of that file; a missing or damaged one is as good as an empty one
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._known: dict[str, list] = {}
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
            self._known = {name: [*entry] for name, entry in found.items() if len(entry) == 2}
        except (OSError, ValueError, TypeError, AttributeError):
            pass
        self._saved = dict(self._known)

    def sha256(self, file: str | Path) -> str:
        """SHA-256 of a file, read only where its stamp is not the known one; raises FoggyError if it cannot be read."""
        now, known = stamp(file), self._known.get(str(file))
        return known[1] if known is not None and now and known[0] == now else self.take(file)

    def take(self, file: str | Path) -> str:
        """SHA-256 of a file, read whatever is known of it; raises FoggyError if it cannot be read."""
        before = stamp(file)
        digest = sha256(file)
        changed = max(before[1:3], default=0)
        fine = SETTLED_NS if changed % 1_000_000 else COARSE_NS
        sure = stamp(file) == before and time.time_ns() - changed > fine
        self._known[str(file)] = [before if sure else [], digest]
        return digest

    def state(self, file: str | Path, recorded: str) -> str:
        """Whether a file is as recorded: "unchanged", "changed" or "missing"."""
        if not Path(file).is_file():
            return "missing"
        return "unchanged" if self.sha256(file) == recorded else "changed"

    def save(self) -> None:
        """Write what is known, if anything of it is new."""
        if self._known != self._saved:
            write_text(self.path, json.dumps(self._known))
            self._saved = dict(self._known)
