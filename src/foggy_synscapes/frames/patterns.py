"""Files named by patterns, such as 'image_02/*.png': which there are, and which of another pattern belongs to each.

`*` is any part of a name, `?` one letter, `**/` any number of folders. What they stand for in the path of an image,
they stand for in the path of its depth and of its camera.
"""

import re
from collections.abc import Sequence
from pathlib import Path

WILD = re.compile(r"\*\*/|\*|\?")
STANDS_FOR = {"**/": "((?:[^/]+/)*)", "*": "([^/]*)", "?": "([^/])"}


class Pattern:
    """Paths that a pattern names.

    base : folder before its first wildcard; wildcards : how many it has

    >>> Pattern("a/*/depth_*.npy").filled(["seq1", "0007"]).as_posix()
    'a/seq1/depth_0007.npy'
    """

    def __init__(self, text: str) -> None:
        parts = Path(text).parts
        fixed = next((at for at, part in enumerate(parts) if is_pattern(part)), len(parts))
        self.text, self.base = text, Path(*parts[:fixed])
        self._rest = "/".join(parts[fixed:])
        if self._rest.endswith("**"):
            self._rest += "/*"
        self.wildcards = len(WILD.findall(self._rest))
        pieces = re.split(f"({WILD.pattern})", self._rest)
        self._names = re.compile("".join(STANDS_FOR.get(piece) or re.escape(piece) for piece in pieces), re.DOTALL)

    def files(self) -> list[tuple[Path, tuple[str, ...]]]:
        """Files of the pattern, sorted, each with what its wildcards stand for; none that is hidden."""
        if not self.wildcards:
            return [(self.base, ())] if self.base.is_file() else []
        found = []
        for path in sorted(self.base.glob(self._rest)):
            match = self._names.fullmatch(path.relative_to(self.base).as_posix())
            if match and not path.name.startswith(".") and path.is_file():
                found.append((path, match.groups()))
        return found

    def filled(self, words: Sequence[str]) -> Path:
        """The path where the wildcards stand for these words; further words do not count."""
        rest, at = self._rest, iter(words)
        return self.base / WILD.sub(lambda _: next(at), rest)


def is_pattern(text: str) -> bool:
    """Whether a text has wildcards."""
    return WILD.search(text) is not None
