"""What faults do to a run: kills at random moments, a full disk, no memory, a wrong clock, two at once: `make faults`.

    python tests/long/faults.py [--kills N] [--seed S] [--only CASE]

Kills: the smoke chain is run, killed by kill -9 at a random moment (all processes, the engine alone, or one worker) and
run again by the normal command, which is killed again and so on, until it comes to its end; then every result must be
that of a clean run. This is repeated by both engines in turn, until N processes were killed. The other cases make one
run fail; it has to say why, and the next run has to come to the results of a clean run.
"""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from engines import environment, hashes
from kills import ENGINES, HOW, call, pause, prepared, run_until

KEPT, MODEL = "results/filter/kept.csv", "results/train/refinenet/C/seed-0/model.safetensors"
STAGES = {KEPT: "filter", MODEL: "train_from_weights@refinenet-C-0"}
TORN = "was torn by a kill"  # what the command says when it mends a file that DVC writes in place
NO_SPACE, NO_MEMORY = "No space left on device", "memory"


def kills(count: int, seed: int, scratch: Path, clean: dict[str, str]) -> int:
    """Kill runs until so many kills are done; the number of chains whose results are not those of a clean run."""
    choice, done, chains, wrong = random.Random(seed), 0, 0, 0
    while done < count:
        engine = ENGINES[chains % len(ENGINES)]
        folder, log = prepared(engine, scratch / f"chain {chains}"), scratch / f"{chains}.log"
        here, state, most = [], "killed", min(10, -(-count // len(ENGINES)), count - done)
        while state == "killed":
            # At most ten times in a chain, so that it comes to its end.
            seconds = choice.uniform(0.5, 40) if len(here) < most else None
            how = choice.choice(HOW)
            state = run_until(engine, folder, log, seconds, how, choice)
            if state == "killed":
                here.append(f"{how} after {seconds:.1f} s")
                pause()
        found = hashes(folder) if state == "done" else {}
        equal = state == "done" and found == clean
        torn = log.read_text(errors="replace").count(TORN)
        told = f"; {torn} times a file of DVC's own was torn, and mended" if torn else ""
        done, chains, wrong = done + len(here), chains + 1, wrong + (not equal)
        moments = ", ".join(here) + told
        verdict = "equal" if equal else "NO"
        print(f"| kill -9, {engine} | {len(here)} kills: {moments} | {verdict} |", flush=True)
        if not equal:
            print(log.read_text(errors="replace")[-3000:], file=sys.stderr)
            different = [path for path in found.keys() | clean.keys() if found.get(path) != clean.get(path)]
            print(f"    differ: {sorted(different)[:10]}", file=sys.stderr)
        shutil.rmtree(folder)
    print(
        f"| kill -9, both engines | {done} kills in {chains} chains, seed {seed} | {chains - wrong} of {chains} equal |"
    )
    return wrong


def faulty(folder: Path, arguments: list[str], before: str = "") -> tuple[int, str]:
    """Run a command in a clone, after a line of shell such as a limit; its exit status and what it said."""
    line = f'{before} exec "$@"'
    result = subprocess.run(
        ["bash", "-c", line, "bash", *arguments],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    logs = "".join(path.read_text(errors="replace") for path in sorted((folder / "results/logs").rglob("*.log")))
    return result.returncode, result.stdout + result.stderr + logs


def engine(name: str, goal: str = KEPT) -> list[str]:
    """The command of an engine up to a result: the first steps of the chain, where the faults are those of all."""
    if name == "dvc":
        return [*call("dvc"), STAGES[goal]]
    return [sys.executable, "-m", "snakemake", goal, "--cores", "1", "--configfile", "params/smoke.yaml"]


@contextmanager
def small_disk(folder: Path, size: str) -> Iterator[None]:
    """A file system of this size in the place of results/."""
    (folder / "results").mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder / "results")], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder / "results")], check=True)


def disk_full(folder: Path, name: str) -> tuple[int, str]:
    """A disk that has room for 400 kB, and then for all; the results must survive the move."""
    with small_disk(folder, "400k"):
        status, said = faulty(folder, engine(name))
        broken = list((folder / "results").rglob("*.part"))
        assert not broken, f"half files are left: {broken}"
    return status, said


def read_only(folder: Path, name: str) -> tuple[int, str]:
    """A folder of results that cannot be written to, not even by root."""
    results = folder / "results"
    results.mkdir(exist_ok=True)
    subprocess.run(["mount", "--bind", str(results), str(results)], check=True)
    subprocess.run(["mount", "-o", "remount,ro,bind", str(results)], check=True)
    try:
        return faulty(folder, engine(name))
    finally:
        subprocess.run(["umount", str(results)], check=True)


def no_memory(folder: Path, name: str) -> tuple[int, str]:
    """A training on crops of 4096 x 4096 pixels, where each process may address 3 GB."""
    files = [folder / "params/smoke.yaml", folder / "params.yaml"]
    texts = [path.read_text() for path in files]
    for path, text in zip(files, texts, strict=True):
        path.write_text(text.replace("crop: [64, 64]", "crop: [4096, 4096]"))
    told = faulty(folder, engine(name, MODEL), "ulimit -v 3000000;")
    for path, text in zip(files, texts, strict=True):
        path.write_text(text)
    return told


def wrong_clock(folder: Path, name: str) -> tuple[int, str]:
    """Results from the future: the clock was a day ahead when they were made, and is set back."""
    status, said = faulty(folder, engine(name))
    tomorrow = time.time() + 86400
    for path in (folder / "results").rglob("*"):
        os.utime(path, (tomorrow, tomorrow))
    again, more = faulty(folder, engine(name))
    return max(status, again), said + more


def two_at_once(folder: Path, name: str) -> tuple[int, str]:
    """The other engine, started while this one runs: it has to do nothing and say why, and this one to go on."""
    other = next(each for each in ENGINES if each != name)
    first = subprocess.Popen(engine(name), cwd=folder, env=environment(), stdout=-3, stderr=-3)
    while first.poll() is None and not any((folder / "results/scenes").glob("*")):
        time.sleep(0.05)
    status, said = faulty(folder, engine(other))
    return (0 if first.wait() else status), said


CASES: dict[str, tuple[Callable, tuple[str, ...], bool, str]] = {
    # what is done, what has to be said (one of these), whether the run has to fail, and what the next one has to make
    "disk full": (disk_full, (NO_SPACE,), True, KEPT),
    "read-only folder": (read_only, ("Read-only file system",), True, KEPT),
    "out of memory": (no_memory, (NO_MEMORY, "Memory"), True, MODEL),
    "clock set back": (wrong_clock, ("",), False, KEPT),
    "two engines at once": (two_at_once, ("another run is at work",), True, KEPT),
}


def cases(chosen: str, scratch: Path, clean: dict[str, str]) -> int:
    """Run the other cases by both engines; the number of those that are not as promised."""
    wrong = 0
    for title, (fault, words, fails, goal) in CASES.items():
        for name in ENGINES:
            if chosen not in title:
                continue
            folder = prepared("dvc", scratch / f"{title} {name}")  # Snakemake runs there as well
            status, said = fault(folder, name)
            clear = any(word in said for word in words) and "Traceback" not in said and bool(status) >= fails
            after, more = faulty(folder, engine(name, goal))
            found = hashes(folder)
            equal = after == 0 and all(clean[path] == digest for path, digest in found.items() if path in clean)
            equal = equal and goal in found
            wrong += not (clear and equal)
            told = "a clear message" if clear and fails else "no harm" if clear else "NO CLEAR MESSAGE"
            print(f"| {title}, {name} | {told} | next run {'equal' if equal else 'NOT EQUAL'} |", flush=True)
            if not (clear and equal):
                print(f"exit status {status}: {said[-3000:]}\n--- then {after}: {more[-1500:]}", file=sys.stderr)
            shutil.rmtree(folder)
    return wrong


def main() -> int:
    """Print a line for each case; 1 where any is not as promised."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=50, metavar="N", help="kills in all (default: 50)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the moments and victims (default: 0)")
    parser.add_argument("--only", default="", metavar="CASE", help=f"one of: kills, {', '.join(CASES)}")
    parser.add_argument("--clean", type=Path, metavar="DIR", help="clone with a finished smoke run, where there is one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        scratch, choice = Path(name), random.Random(0)
        print("| fault | what happened | results |\n| --- | --- | --- |", flush=True)
        folder = options.clean or prepared("snakemake", scratch / "clean")
        if options.clean is None:
            state = run_until("snakemake", folder, scratch / "clean.log", None, "all", choice)
            assert state == "done", (scratch / "clean.log").read_text()[-3000:]
        clean = hashes(folder)
        wrong = cases(options.only, scratch, clean) if options.only != "kills" else 0
        if options.only in ("", "kills"):
            wrong += kills(options.kills, options.seed, scratch, clean)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
