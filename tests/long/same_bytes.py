"""Whether clean runs give the same bytes wherever they are made: `make same-bytes`.

    python tests/long/same_bytes.py [--only TEXT]

Runs the smoke chain from nothing by either engine, on 1 and 2 cores, in another folder, time zone, language and order
of hashes, and compares the SHA-256 of every file under results/ but logs and benchmarks.
"""

import argparse
import hashlib
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from engines import SMOKE, clone, for_dvc, hashes, own_sources, run

PLAIN = {"TZ": "UTC", "LANG": "C.UTF-8", "PYTHONHASHSEED": "0"}
# No UTF-8 at all: a file that is opened without naming its encoding is then read as ASCII.
POSIX = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
CASES = (
    ("snakemake", "1", "plain", PLAIN),
    ("snakemake", "2", "it's a folder with spaces & ümlauts", {"TZ": "Pacific/Chatham", "PYTHONHASHSEED": "4711"}),
    ("snakemake", "2", "posix", {**POSIX, "TZ": "America/St_Johns", "PYTHONHASHSEED": "random"}),
    ("dvc", "1", "another folder", {"TZ": "Asia/Kathmandu", "LANG": "tr_TR.UTF-8", "PYTHONHASHSEED": "1"}),
)


def main() -> int:
    """Print a line for each run; 1 where any differs from the first."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT", help="only runs whose engine or folder holds this text")
    options = parser.parse_args()
    first, failed = {}, 0
    print("| engine | cores | folder | environment | files | SHA-256 of all | equal |\n|" + " --- |" * 7, flush=True)
    for engine, cores, name, changes in CASES:
        if options.only not in engine and options.only not in name:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            folder = clone(Path(scratch) / name)
            changes = {**changes, **own_sources(folder)}
            if engine == "snakemake":
                run(folder, "snakemake", "--cores", cores, *SMOKE, changes=changes)
            else:
                run(for_dvc(folder), "dvc", "repro", changes=changes)
            found = hashes(folder)
        first = first or found
        total = hashlib.sha256("\n".join(f"{path} {found[path]}" for path in sorted(found)).encode()).hexdigest()[:16]
        told = ", ".join(f"{key}={value}" for key, value in changes.items() if key != "PYTHONPATH")
        equal = "yes" if found == first else "NO"
        print(f"| {engine} | {cores} | {name} | {told} | {len(found)} | {total} | {equal} |", flush=True)
        for path in sorted(found.keys() | first.keys()):
            if found.get(path) != first.get(path):
                print(f"    differs: {path}", file=sys.stderr)
        failed += found != first
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
