"""Changes that times do not tell, on the tiny chain, run by Snakemake: `python tests/long/real_changes.py [WORD ...]`.

Each begins with a finished run. After the change the normal command runs, and each file is compared with a clean run of
the same state. Prints a line for each change and the counts.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

import tiny_chain

MODEL = Path("results/train/0/model.txt")


def edit(path: str | Path, text: str) -> None:
    """Edit a file that keeps its times, as after `rsync -a`, `tar` or `cp -p`."""
    status = Path(path).stat()
    Path(path).write_text(text)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def params(**values: object) -> None:
    edit("params.yaml", json.dumps(tiny_chain.changed(json.loads(Path("params.yaml").read_text()), **values)))


def by_hand() -> None:
    """A person runs one job with other params, and puts the params back."""
    kept = Path("params.yaml").read_text()
    params(stability__digits=40)
    subprocess.run([sys.executable, tiny_chain.__file__, "train", "--seed", "0"], check=True)
    edit("params.yaml", kept)


def touched() -> None:
    """Code is edited, and somebody touches the results, or `snakemake --touch` does."""
    edit("toy/train.py", "VALUE = 5")
    subprocess.run([*tiny_chain.snakefile(Path()), "--touch", "--forceall"], check=True, capture_output=True)


CHANGES: dict[str, Callable[[], None]] = {
    "nothing": lambda: None,
    "code of a step": lambda: edit("toy/fog.py", "VALUE = 5"),
    "code of a step, then --touch": touched,
    "params": lambda: params(stability__digits=40),
    "start weights, with an old time": lambda: edit(tiny_chain.WEIGHTS, "v"),
    "a model, with an old time": lambda: edit(MODEL, "other"),
    "a table by hand": lambda: Path("results/tables/foggy_zurich.csv").write_text("better"),
    "a shard's manifest, with an old time": lambda: edit("results/fog/0000.csv", "other"),
    "a job by hand with other params": by_hand,
    "raw data in place, with an old time": lambda: edit("raw/a.txt", "z"),
    "results without Snakemake's records, other params": lambda: (
        shutil.rmtree(".snakemake"),
        params(fog__png_level=2),
    ),
    "a record": lambda: edit(MODEL.with_name("run.json"), "{}"),
}


def normal_command(call: list[str]) -> str:
    """What the engine says; where it asks for a dataset to be listed anew, that is done first."""
    for _ in range(2):
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return ""
        if "as they were listed" not in done.stderr + done.stdout:
            return (done.stderr + done.stdout).strip().splitlines()[-1]
        subprocess.run([sys.executable, tiny_chain.__file__, "scenes", "--dataset", "synscapes"], check=True)
    return "asks again for what was done"


def contents() -> dict[str, str]:
    paths = [path for path in Path("results").rglob("*") if path.is_file()]
    return {
        str(path): path.read_text()
        for path in sorted(paths)
        if path.parts[1] not in ("logs", "benchmarks") and not path.name.startswith(".")
    }


def main() -> int:
    """0 where each change ends in the results of a clean run."""
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        base = Path(name, "base")
        tiny_chain.start(base)
        os.chdir(base)
        assert normal_command(tiny_chain.snakefile(Path())) == ""
        chosen = {what: CHANGES[what] for what in CHANGES if any(word in what for word in sys.argv[1:] or [""])}
        for number, (what, change) in enumerate(chosen.items()):
            folder = tiny_chain.copied(base, Path(name, str(number)), times=True)
            os.chdir(folder)
            change()
            said = normal_command(tiny_chain.snakefile(Path()))
            found = contents()
            for path in ("results", ".snakemake", ".foggy"):
                shutil.rmtree(path, ignore_errors=True)
            assert normal_command(tiny_chain.snakefile(Path())) == ""
            clean = contents()
            stale = [path for path in clean if found.get(path) != clean[path]]
            failed += bool(stale or said)
            print(f"{what}: {said or ('stale: ' + ', '.join(stale) if stale else 'as a clean run')}", flush=True)
    print(f"{len(chosen)} changes, {failed} that do not end as a clean run")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
