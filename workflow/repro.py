"""Run DVC, after a kill too: `make repro`, or `python workflow/repro.py [options of dvc repro]`.

DVC writes two files of its own in place, dvc.lock and .dvc/tmp/rwlock. A kill at that moment leaves half of one, and
`dvc repro` then refuses to start. Here such a file is removed first: what steps made is in DVC's run cache, which takes
the place of dvc.lock, and rwlock, which says who reads and writes at the moment, begins anew.
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
from foggy_synscapes.io.atomic import remove_leftovers
from foggy_synscapes.provenance.current import changed_raw_data
from foggy_synscapes.provenance.runs import PLANNED, params_digest
from foggy_synscapes.results import RESULTS
from foggy_synscapes.steps import all_jobs

LOCK = Path("dvc.lock")


def repair(repo: Repo) -> list[str]:
    """Remove what a kill tore of DVC's own files, while no other DVC is at work on them; the names of those removed."""
    removed = []
    with repo.lock:
        locks = Path(repo.tmp_dir, RWLOCK_FILE)
        with make_lock(str(locks.with_name(RWLOCK_LOCK)), tmp_dir=repo.tmp_dir):
            for path, is_whole in ((LOCK.resolve(), _is_lock_file), (locks, _says_who_reads)):
                if path.is_file() and not is_whole(path):
                    path.unlink()
                    removed.append(str(path.relative_to(repo.root_dir)))
    return removed


def _is_lock_file(path: Path) -> bool:
    try:
        COMPILED_LOCKFILE_SCHEMA(parse_yaml(path.read_text(encoding="utf-8"), path))
    except (YAMLFileCorruptedError, Invalid, UnicodeDecodeError):
        return False
    return True


def _says_who_reads(path: Path) -> bool:
    try:
        SCHEMA(json.loads(path.read_bytes()))
    except (ValueError, Invalid):
        return False
    return True


def renew_indexes(repo: Repo, planned: params.Params) -> int:
    """List datasets anew where DVC would not, or would take an older list from its cache: it does not see their files.

    Returns the first exit status that is not 0.
    """
    stages = {stage.addressing for stage in repo.index.stages}
    jobs = {job.step.name: job for job in all_jobs(planned) if job.step.word == "scenes" and job.step.name in stages}
    unlike = {*repo.status(targets=[*jobs])} if LOCK.is_file() else {*jobs}
    listed = [name for name, job in jobs.items() if name in unlike or changed_raw_data(job)]
    for name in ["code", *listed] if listed else []:
        status = dvc(["repro", "--single-item", *(["--force"] if name in jobs else []), name])
        if status:
            return status
    return 0


def main(options: list[str]) -> int:
    """Repair, then run `dvc repro` with these options; its exit status.

    The params are checked before DVC reads them as they stand and puts their values into shell lines.
    """
    try:
        repo = Repo()
        os.chdir(repo.root_dir)
        params.require_complete("params.yaml")
        planned = params.load("params.yaml")
        os.environ[PLANNED] = params_digest(planned)
        os.environ[lock.HELD] = "dvc"  # its jobs, should they outlive it, are then waited for, not taken for a run
        with lock.hold():
            remove_leftovers(RESULTS)
            for name in repair(repo):
                print(f"repro: {name} was torn by a kill; it begins anew", file=sys.stderr)
            status = renew_indexes(repo, planned)
            return status or dvc(["repro", *options])
    except (DvcException, FoggyError) as error:
        print(f"repro: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
