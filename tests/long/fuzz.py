"""Changed files given to every reader: `make fuzz`, or python tests/long/fuzz.py [INPUTS] [SEED]

Prints for each reader how many inputs were refused by name, gave the same output, another one, and what must not be:
accepted against a checksum, refused without the file's name, a traceback, a hang. It fails on the latter.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from fuzz import READERS, fuzz


def main(inputs: int = 5000, seed: int = 0) -> int:
    """Spread the inputs over all readers; 1 where one did not do."""
    counts = fuzz(-(-inputs // len(READERS)), seed, [reader.name for reader in READERS])
    print(counts)
    print("\n".join(counts.examples))
    return 1 if counts.bad() else 0


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:])))
