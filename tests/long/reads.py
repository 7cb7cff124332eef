"""Whether each step reads and writes what it declares, and nothing else: `make reads`.

    python tests/long/reads.py [--only TEXT] [--clones DIR]

Jobs of a finished smoke run are run once more under an audit hook of Python, worker processes included; trainings with
one that loads images. It fails on any file read that is not a declared input, named with its hash by a declared list or
index, an output of the same job, the params file or part of an installed package; on any file written that is not an
output; on use of the network or of other programs; on outputs that come out otherwise than the first time, as they
would with the time of day in them; and on any module that counts for a step and that no job of it imports.
"""

import argparse
import sys
import tempfile
from fnmatch import fnmatchcase
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from engines import SMOKE, clone, complete, own_sources, planned, run
from reads import counted, undeclared, watch

from foggy_synscapes.io.hashing import sha256

# What other rows do, too, is looked at once.
JOBS = ("scenes *", "filter", "fog *", "subset *", "train * C 0", "train bisenet FC-FS-498 0", "evaluate bisenet C 0 *")
JOBS += ("tables *", "figures *", "stability")


def dotted(file: str) -> str:
    """Name of a module from its file below the package, as it counts.

    >>> dotted("fog/__init__.py"), dotted("fog/optics.py")
    ('fog', 'fog.optics')
    """
    return file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def main() -> int:
    """Print a line for each job; 1 where one reads what it does not declare, or declares what it never imports."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT", help="only jobs whose name holds this text")
    parser.add_argument(
        "--clones", type=Path, metavar="DIR", help="folder for the finished run, kept for the next time"
    )
    options = parser.parse_args()
    failed, imported, code = 0, {}, {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = (options.clones or Path(scratch)) / "snakemake"
        if not folder.exists():
            run(clone(folder), "snakemake", "--cores", "2", *SMOKE, changes=own_sources(folder))
        params = folder / SMOKE[1]
        params.write_text(complete(params).replace("workers: 0", "workers: 1"))
        for name, (inputs, outputs, command) in sorted(planned(folder, "--forceall").items()):
            if options.only not in name or not any(fnmatchcase(name, pattern) for pattern in JOBS):
                continue
            before = {path: sha256(folder / path) for path in outputs}
            reads = watch(folder, command)
            problems = undeclared(folder, command, inputs, outputs, SMOKE[1], reads)
            problems += [f"{path} came out otherwise" for path in outputs if sha256(folder / path) != before[path]]
            if name.startswith("train") and reads.processes < 2:
                problems.append("no worker process was seen")
            imported.setdefault(name.split()[0], set()).update(map(dotted, reads.modules))
            code.setdefault(name.split()[0], set()).update(counted(folder, command, SMOKE[1]))
            told = f"{len(reads.files)} files read, {len(reads.written)} written, {reads.processes} processes"
            print(f"{name}: {told}; {len(problems)} problems", flush=True)
            for problem in problems:
                print(f"    {problem}", flush=True)
            failed += bool(problems)
    for word, modules in imported.items():
        never = sorted(name for name in code[word] - modules if "/" not in name)
        if never and not options.only:
            print(f"{word}: counts but never imports {', '.join(never)}")
            failed += 1
    print(f"{failed} of {len(imported)} steps or their jobs are not as declared" if failed else "all as declared")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
