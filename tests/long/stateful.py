"""Random histories of a project folder for as long as asked: `make stateful`, or `python tests/long/stateful.py`.

Prints how many histories and steps there were, results that were stale, commands stuck and jobs run without need.
"""

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

import stateful
from hypothesis.stateful import run_state_machine_as_test


def main() -> int:
    """0 where every history ended well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60)
    end = time.monotonic() + 60 * parser.parse_args().minutes
    failed = []
    while time.monotonic() < end:
        try:
            run_state_machine_as_test(stateful.History, settings=stateful.SETTINGS)
        except Exception as error:
            failed.append(error)
            print("\n".join([str(error), *getattr(error, "__notes__", [])]), flush=True)
    print(stateful.told())
    return len(failed) > 0


if __name__ == "__main__":
    sys.exit(main())
