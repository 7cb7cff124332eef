"""A chain of eight jobs that take milliseconds, on the machinery of the real one: records, planning, locks, engines.

Four words keep their names and places in the table of steps, but read and write a few bytes. What counts of their code
is a file below `toy`. As a program, `python tiny_chain.py WORD ...` runs one job, as the engines do.
"""

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from engines import VERBOSE

from foggy_synscapes import jobs, steps
from foggy_synscapes.datasets.index import read_index, write_index
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.jobs import Each, Job, Step
from foggy_synscapes.params import Params, check, load
from foggy_synscapes.provenance import current, source_digest
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import root

ROOT = Path(__file__).resolve().parents[2]
WORDS = ("scenes", "fog", "train", "tables")
INDEX = "results/scenes/index/synscapes/all.csv"
WEIGHTS = "weights.txt"
BASE: dict[str, Any] = {
    "scenes": {"roots": {"synscapes": "raw"}, "shards": ["0000"]},
    "fog": {"png_level": 1},
    "stability": {"digits": 30},
    "figures": {"images": 2},
}
FOG = Each("results/fog", "{shard}.csv", {"shard": ("scenes.shards",)})
TRAINED = Each("results/train", "{seed}/model.txt", {"seed": ("train.seeds",)})


class Killed(Exception):
    """Stands for the end of a process in the middle of its work."""


def _weights(params: Params, values: jobs.Values) -> list[str]:
    return [WEIGHTS] if Path(WEIGHTS).is_file() else []


TABLE = [
    Step(
        name="scenes_synscapes",
        word="scenes",
        text="List raw files.",
        command="scenes --dataset synscapes",
        outputs={"index": INDEX, "record": "results/scenes/index/synscapes/run.json"},
        params=("scenes.roots.synscapes",),
    ),
    Step(
        name="fog",
        word="fog",
        text="Make fog.",
        command="fog --shard {shard}",
        wildcards={"shard": "scenes.shards"},
        inputs={"index": INDEX},
        outputs={
            "manifest": "results/fog/{shard}.csv",
            "shard": "results/fog/{shard}.tar",
            "record": "results/fog/{shard}.run.json",
        },
        params=("fog.png_level",),
    ),
    Step(
        name="train",
        word="train",
        text="Train.",
        command="train --seed {seed}",
        wildcards={"seed": "train.seeds"},
        inputs={"fog": FOG},
        outputs={"model": "results/train/{seed}/model.txt", "record": "results/train/{seed}/run.json"},
        params=("stability.digits",),
        optional=_weights,
        waits=lambda params, values: [f"results/fog/{shard}.tar" for shard in params.scenes.shards],
    ),
    Step(
        name="tables",
        word="tables",
        text="Make a table.",
        command="tables --test-set {test_set}",
        wildcards={"test_set": "evaluate.test_sets"},
        inputs={"models": TRAINED},
        outputs={"csv": "results/tables/{test_set}.csv", "record": "results/tables/{test_set}.run.json"},
        params=("figures.images",),
    ),
]


def code(word: str, _entries: object = (), _registries: object = None) -> tuple[dict[str, str], dict[str, str]]:
    """What counts of the code of a word: the meaning of its file."""
    return {f"toy/{word}.py": source_digest.meaning(Path(f"toy/{word}.py").read_bytes())}, {}


def files_of(_name: str, folder: Path, *_: object) -> list[str]:
    """Raw files, as the datasets' own modules list them."""
    return [path.name for path in folder.iterdir()]


def _command(job: Job) -> list[str]:
    return [
        sys.executable,
        __file__,
        *(job.step.fill(part, job.params, job.values) for part in job.step.command.split()),
    ]


@contextmanager
def installed() -> Iterator[None]:
    """The chain in place of the real one, while the block lasts."""
    before = steps._steps, source_digest.code, current.files_of, Job.command
    install()
    try:
        yield
    finally:
        steps._steps, source_digest.code, current.files_of, Job.command = before  # type: ignore[assignment, method-assign]


def install() -> None:
    """Put the chain in the place of the real one, in this process."""
    steps._steps = lambda _plugins: TABLE  # type: ignore[assignment]
    source_digest.code = code
    current.files_of = files_of  # type: ignore[attr-defined]
    Job.command = property(_command)  # type: ignore[assignment, method-assign]


def start(folder: Path) -> None:
    """Write what is there before anything has run."""
    for word in WORDS:
        write_text(folder / f"toy/{word}.py", "VALUE = 0\n")
    for name in "ab":
        write_text(folder / f"raw/{name}.txt", name)
    write_text(folder / WEIGHTS, "w")
    write_text(folder / "params.yaml", json.dumps(BASE))


def changed(document: dict[str, Any], **values: Any) -> dict[str, Any]:
    """A params file's document with other values of dotted keys, in which `__` stands for the dot."""
    document = json.loads(json.dumps(document))
    for key, value in values.items():
        section, _, name = key.partition("__")
        document.setdefault(section, {})[name] = value
    return document


@cache
def _params(text: str) -> Params:
    return check(json.loads(text), "params.yaml")


def params_here() -> Params:
    """The params of the working folder; equal ones are read once."""
    return _params(Path("params.yaml").read_text())


Stop = dict[str, Callable[[], None]]
"""What happens in the middle of a job, by where: `begun`, `half` of its outputs written, or `unrecorded`."""


def kill() -> None:
    """End a job as a kill does."""
    raise Killed


def run(job: Job, stop: Stop | None = None) -> None:
    """Run a job, in the middle of which something may happen."""
    word, params = job.step.word, job.params
    value: dict[str, Any] = {}
    exec(Path(f"toy/{word}.py").read_text(), value)
    read = [path for path in job.read() if path.is_file()] if word == "tables" else None
    made = Run(job, read)
    _at("begun", stop)
    said = json.dumps([word, value["VALUE"], made.params], sort_keys=True)
    if word == "scenes":
        folder = root(params, "synscapes")
        write_index(job.output("index"), folder, files_of("synscapes", folder))
    elif word == "fog":
        folder = root(params, "synscapes")
        images = [read_checked(folder / path, digest).decode() for path, digest in read_index(Path(INDEX)).items()]
        write_text(job.output("shard"), f"{said} {job.values['shard']} {images}")
        _at("half", stop)
        write_text(job.output("manifest"), f"{said} {job.values['shard']} {images} manifest")
    else:
        texts = [path.read_text() for path in (job.read() if read is None else read)]
        name = "model" if word == "train" else "csv"
        write_text(job.output(name), f"{said} {job.values} {texts}")
    if word != "fog":
        _at("half", stop)
    _at("unrecorded", stop)
    made.finish()


def _at(point: str, stop: Stop | None) -> None:
    if stop and point in stop:
        stop[point]()


def main(words: list[str]) -> int:
    """Run the job of a command line, as `foggy` would."""
    from foggy_synscapes.errors import FoggyError
    from foggy_synscapes.io import lock

    install()
    if "--params" in words:
        words = words[: words.index("--params")]
    try:
        with lock.join():
            params = load("params.yaml")
            jobs = [Job(step, params, values) for step in TABLE for values in step.all_values(params)]
            (job,) = [job for job in jobs if job.command[2:] == words]
            run(job)
    except FoggyError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def snakefile(folder: Path) -> list[str]:
    """Write a Snakefile that is the project's with this chain; the call that runs it, on one core, in `folder`."""
    head = f"import sys\nsys.path.insert(0, {str(Path(__file__).parent)!r})\nimport tiny_chain\ntiny_chain.install()\n"
    whole = (ROOT / "Snakefile").read_text().replace('"workflow/', f'"{ROOT}/workflow/')
    write_text(folder / "Snakefile", head + whole)
    call = [sys.executable, "-m", "snakemake", "--cores", "1", "--configfile", "params.yaml"]
    # The project's profile, but for what it leaves unsaid.
    return [*call, "--workflow-profile", str(ROOT / "workflow/profiles/default"), *VERBOSE]


def copied(folder: Path, target: Path, times: bool) -> Path:
    """A copy of the whole folder, with or without its times."""
    shutil.copytree(folder, target, symlinks=True, copy_function=shutil.copy2 if times else shutil.copy)
    return target


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main(sys.argv[1:]))
