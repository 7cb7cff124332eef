"""adopt: carry a clone from one engine to the other, after making sure that what is there is what should be."""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.params import load, require_complete
from foggy_synscapes.provenance.check import verify
from foggy_synscapes.results import RESULTS

HELP = (
    "Let the other engine take over what one engine made, so that it makes nothing again. Refused where the first one "
    "still has work to do or a file is not what its run record says: that would certify stale or altered results."
)
DEFAULT = Path("params.yaml")
SHOWN = 15  # lines of an engine's answer that are repeated


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument(
        "--from", dest="engine", required=True, choices=["snakemake", "dvc"], help="engine that made the results"
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    adopt(args.engine, args.params)


def adopt(engine: str, params: Path = DEFAULT) -> None:
    """Make the results of `engine` known to the other one.

    Raises
    ------
    UsageError
        If this is not the project's folder, or the params file says something else than the params.yaml of DVC.
    FoggyError
        If `engine` has work to do, a result is not as recorded, or the other engine does not take the results over.
    """
    absent = [name for name in ("Snakefile", "dvc.yaml", str(DEFAULT)) if not Path(name).is_file()]
    if absent:
        raise UsageError(f"no {', '.join(absent)} here. Run foggy adopt in the project's folder.")
    require_complete(DEFAULT)
    if params != DEFAULT and load(params) != load(DEFAULT):
        raise UsageError(
            f"--params {params}: says something else than {DEFAULT}, the only one that DVC reads. Make them one: "
            f"foggy params --file {params} --out {DEFAULT}"
        )
    option = [] if params == DEFAULT else ["--configfile", str(params)]
    if engine == "snakemake":
        _from_snakemake(option)
    else:
        _from_dvc(option)


def _from_snakemake(option: list[str]) -> None:
    count = verify(Path(RESULTS))
    waiting = _snakemake_waits(option)
    if waiting:
        raise FoggyError(
            f"Snakemake still has work to do, so what lies in results/ is not what {DEFAULT} asks for:\n{waiting}\n"
            f"Run {_spelt('snakemake --cores 2', option)} first, then this again."
        )
    # What code means is written for DVC alone; Snakemake computes it by itself.
    _engine("foggy_synscapes", "code", "--params", str(DEFAULT))
    # -f: DVC asks about each changed stage otherwise; what it would ask is answered by the checks above.
    _engine("dvc", "commit", "--force", "--quiet")
    waiting = _dvc_waits()
    if waiting:
        raise FoggyError(f"DVC does not take these stages over:\n{waiting}\nRun dvc repro to see why.")
    print(f"adopt: {count} files are what their run records say; dvc repro has nothing to do now")


def _from_dvc(option: list[str]) -> None:
    waiting = _dvc_waits()
    if waiting:
        raise FoggyError(
            f"DVC does not call everything up to date, so what lies in results/ is not what {DEFAULT} asks for:\n"
            f"{waiting}\nRun dvc repro (or dvc checkout, dvc pull) first, then this again."
        )
    count = verify(Path(RESULTS))
    # Snakemake judges by run records, whoever wrote them.
    waiting = _snakemake_waits(option)
    if waiting:
        raise FoggyError(f"Snakemake does not take these over:\n{waiting}\nRun snakemake -n to see why.")
    print(f"adopt: {count} files are what their run records say; {_spelt('snakemake', option)} has nothing to do now")


def _snakemake_waits(option: list[str]) -> str:
    """Counts of the jobs that Snakemake would run; empty where there are none."""
    told = _engine("snakemake", "--dry-run", "--cores", "1", *option)
    if "Nothing to be done" in told:
        return ""
    jobs = re.search(r"^Job stats:\n(.*?)(?:\n\n|\Z)", told, re.MULTILINE | re.DOTALL)
    return _shortened(jobs[1] if jobs else told)


def _dvc_waits() -> str:
    """Stages that DVC does not call up to date, with what changed; empty where there are none."""
    told = _engine("dvc", "status", "--json")
    stages = json.loads(told[told.index("{") :])
    return _shortened("\n".join(f"{name}: {_in_words(changes)}" for name, changes in sorted(stages.items())))


def _in_words(changes: object) -> str:
    """What DVC says of a stage, without its nesting.

    >>> _in_words([{"changed deps": {"params.yaml": {"fog.betas": "modified"}}}, "changed command"])
    'fog.betas modified, changed command'
    """
    if isinstance(changes, dict):
        return ", ".join(
            f"{name} {word}" if isinstance(word, str) else _in_words(word) for name, word in changes.items()
        )
    return ", ".join(map(_in_words, changes)) if isinstance(changes, list) else str(changes)


def _engine(module: str, *arguments: str) -> str:
    """What an engine of this environment prints; FoggyError with the end of its message where it fails."""
    print(f"adopt: {module} {' '.join(arguments)} ...", file=sys.stderr, flush=True)  # it may take minutes
    call = [sys.executable, "-m", module, *arguments]
    result = subprocess.run(call, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        lines = (result.stdout + result.stderr).strip().splitlines()[-SHOWN:]
        raise FoggyError("\n".join([f"{module} {' '.join(arguments)} failed:", *lines]))
    return result.stdout if "--json" in arguments else result.stdout + result.stderr


def _shortened(text: str) -> str:
    lines = text.splitlines()
    return "\n".join(lines if len(lines) <= SHOWN else [*lines[:SHOWN], f"and {len(lines) - SHOWN} more"])


def _spelt(command: str, option: list[str]) -> str:
    return " ".join([command, *option])
