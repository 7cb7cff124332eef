"""Random histories of a project folder, on the tiny chain: one command makes what a clean run makes."""

import contextlib
import json
import os
import shutil
import tempfile
from collections import Counter
from pathlib import Path

import tiny_chain
import tiny_engines
from hypothesis import HealthCheck, Phase, note, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.steps import all_jobs

COUNTS: Counter = Counter()
"""Histories, steps, and what was found: stale results, commands that got stuck, jobs that ran without need."""
MEMORY = Path("/dev/shm")
VALUES = {
    "scenes__shards": [["0000"], ["0000", "0001"]],
    "fog__png_level": [1, 2],
    "stability__digits": [30, 40],
    "figures__images": [2, 3],
    "train__seeds": [["0"], ["0", "1"]],
    "evaluate__test_sets": [["foggy_driving"], ["foggy_driving", "foggy_zurich"]],
}
SETTINGS = settings(
    max_examples=20,
    stateful_step_count=30,
    deadline=None,
    phases=[Phase.generate],  # what it found once is found by other steps, too: no time is spent to shorten it
    report_multiple_bugs=False,
    database=None,
    suppress_health_check=list(HealthCheck),
)
POINTS = ["begun", "half", "unrecorded"]


class History(RuleBasedStateMachine):
    """One folder, in which a person edits, copies, kills and runs."""

    def __init__(self) -> None:
        super().__init__()
        self.home, self.before = Path(tempfile.mkdtemp(dir=MEMORY if MEMORY.is_dir() else None)), Path.cwd()
        self.folder, self.copies, self.dvc = self.home / "0", 0, tiny_engines.Dvc()
        self.cleaned: dict[str, dict[str, str | None]] = {}
        self.other_weights = False
        self.tiny = contextlib.ExitStack()
        COUNTS["histories"] += 1

    @initialize()
    def begin(self) -> None:
        self.tiny.enter_context(tiny_chain.installed())
        tiny_chain.start(self.folder)
        os.chdir(self.folder)

    def teardown(self) -> None:
        os.chdir(self.before)
        self.tiny.close()
        shutil.rmtree(self.home)

    def _write(self, path: str, text: str, keep_times: bool) -> None:
        """Edit a file, with its old times as `rsync -a` or `cp -p` bring them."""
        COUNTS["steps"] += 1
        status = Path(path).stat() if Path(path).exists() else None
        Path(path).write_text(text)
        if keep_times and status is not None:
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))

    @rule(word=st.sampled_from(tiny_chain.WORDS), value=st.integers(0, 2), comment=st.booleans(), keep=st.booleans())
    def edit_code(self, word: str, value: int, comment: bool, keep: bool) -> None:
        self._write(f"toy/{word}.py", f"VALUE = {value}{'  # why' if comment else ''}\n", keep)

    @rule(key=st.sampled_from(sorted(VALUES)), which=st.integers(0, 1), keep=st.booleans())
    def edit_params(self, key: str, which: int, keep: bool) -> None:
        document = tiny_chain.changed(json.loads(Path("params.yaml").read_text()), **{key: VALUES[key][which]})
        self._write("params.yaml", json.dumps(document), keep)

    @rule(name=st.sampled_from("abc"), text=st.sampled_from("xyz"), keep=st.booleans())
    def edit_raw(self, name: str, text: str, keep: bool) -> None:
        # A new file is listed by `foggy scenes` alone, as docs/promises.md says: only those that are listed are edited.
        if Path(f"raw/{name}.txt").exists():
            self._write(f"raw/{name}.txt", text, keep)

    @rule(text=st.sampled_from("uvw"), keep=st.booleans())
    def replace_weights(self, text: str, keep: bool) -> None:
        self.other_weights = True  # DVC knows their name alone
        self._write(tiny_chain.WEIGHTS, text, keep)

    @rule(data=st.data(), what=st.sampled_from(["alter", "remove", "record", "older"]), keep=st.booleans())
    def spoil(self, data: st.DataObject, what: str, keep: bool) -> None:
        paths = sorted(path for path in Path("results").rglob("*") if path.is_file())
        if not paths:
            return
        path = str(data.draw(st.sampled_from(paths)))
        if what == "remove":
            Path(path).unlink()
            COUNTS["steps"] += 1
        elif what == "record":
            records = [str(path) for path in paths if "run.json" in path.name]
            if records:
                self._write(data.draw(st.sampled_from(records)), data.draw(st.sampled_from(["", "{}", "[1"])), keep)
        else:
            self._write(path, "altered", keep)

    @rule()
    def remove_folder(self) -> None:
        COUNTS["steps"] += 1
        shutil.rmtree("results/fog", ignore_errors=True)

    @rule(times=st.booleans())
    def copy(self, times: bool) -> None:
        COUNTS["steps"] += 1
        self.copies += 1
        target = tiny_chain.copied(self.folder, self.home / str(self.copies), times)
        os.chdir(target)
        shutil.rmtree(self.folder)
        self.folder = target

    @rule(future=st.booleans())
    def touch(self, future: bool) -> None:
        COUNTS["steps"] += 1
        for path in Path("results").rglob("*"):
            os.utime(path, (2_000_000_000,) * 2 if future else None)

    @rule(data=st.data(), key=st.sampled_from(sorted(VALUES)))
    def by_hand(self, data: st.DataObject, key: str) -> None:
        """A `foggy` line of a person with other params, which may not find what it needs."""
        COUNTS["steps"] += 1
        text = Path("params.yaml").read_text()
        other = tiny_chain.changed(json.loads(text), **{key: VALUES[key][1]})
        write_text("params.yaml", json.dumps(other))
        with contextlib.suppress(FoggyError):
            tiny_chain.run(data.draw(st.sampled_from(all_jobs(tiny_chain.params_here()))))
        write_text("params.yaml", text)

    @rule(number=st.integers(0, 6), point=st.sampled_from(POINTS), dvc=st.booleans())
    def kill(self, number: int, point: str, dvc: bool) -> None:
        COUNTS["steps"] += 1
        command = self.dvc.repro if dvc and not self.other_weights else tiny_engines.snakemake
        with contextlib.suppress(tiny_chain.Killed):
            command(number, {point: tiny_chain.kill})

    @rule(
        number=st.integers(0, 6),
        point=st.sampled_from(POINTS),
        dvc=st.booleans(),
        what=st.sampled_from(["code", "params", "raw", "input", "output"]),
        word=st.sampled_from(tiny_chain.WORDS),
        key=st.sampled_from(sorted(VALUES)),
        share=st.floats(0, 1, exclude_max=True),
    )
    def edit_meanwhile(self, number: int, point: str, dvc: bool, what: str, word: str, key: str, share: float) -> None:
        """An edit while a job runs: the command may refuse to go on, and the next one is as good as any."""

        def edit() -> None:
            if what == "code":
                self.edit_code(word, 2, False, False)
            elif what == "params":
                self.edit_params(key, 1, False)
            elif what == "raw":
                self.edit_raw("a", "y", False)
            elif what == "input":
                self.replace_weights("x", False)
            elif paths := sorted(path for path in Path("results").rglob("*") if path.is_file()):
                self._write(str(paths[int(share * len(paths))]), "altered", False)

        command = self.dvc.repro if dvc and not self.other_weights else tiny_engines.snakemake
        with contextlib.suppress(FoggyError):
            command(number, {point: edit})

    @rule()
    def adopt(self) -> None:
        COUNTS["steps"] += 1
        self.dvc.adopt()

    @rule()
    def snakemake(self) -> None:
        self._command(tiny_engines.snakemake, complete=False)

    @precondition(lambda self: not self.other_weights)
    @rule()
    def repro(self) -> None:
        self._command(self.dvc.repro, complete=True)

    def _command(self, command, complete: bool) -> None:  # type: ignore[no-untyped-def]
        """The normal command of an engine, and what has to hold after it."""
        COUNTS["steps"] += 1
        COUNTS["commands"] += 1
        wanted = self._clean()
        jobs = all_jobs(tiny_chain.params_here())
        before = tiny_engines.contents(jobs)
        try:
            ran = command()
        except FoggyError as error:
            COUNTS["stuck"] += 1
            raise AssertionError(f"stuck: {error}") from error
        after = tiny_engines.contents(jobs)
        asked = {path for job in jobs if job.step.word == "tables" for path in tiny_engines.writes(job)}
        stale = [path for path in wanted if after[path] != wanted[path] and (after[path] or complete or path in asked)]
        needless = [
            name
            for job in jobs
            if (name := tiny_engines.name(job)) in ran.jobs
            and not complete  # what DVC did not make, and was not told of by `foggy adopt`, it makes itself
            and all(before[path] == wanted[path] for path in tiny_engines.writes(job))
        ]
        COUNTS["jobs"] += len(ran.jobs)
        COUNTS["stale"] += len(stale)
        COUNTS["followed"] += len([name for name in needless if name in ran.followed])
        COUNTS["needless"] += len([name for name in needless if name not in ran.followed])
        note(f"ran {ran.jobs}")
        assert stale == [], "other than those of a clean run"
        assert [name for name in needless if name not in ran.followed] == [], "ran without need"

    def _clean(self) -> dict[str, str | None]:
        """What a clean run of this state makes; each state is run once."""
        files = [path for path in Path().rglob("*") if path.is_file() and path.parts[0] in ("toy", "raw")]
        texts = [f"{path} {path.read_text()}" for path in sorted(files)]
        key = json.dumps([*texts, Path("params.yaml").read_text(), Path(tiny_chain.WEIGHTS).read_text()])
        if key not in self.cleaned:
            with tempfile.TemporaryDirectory(dir=self.home) as folder:
                self.cleaned[key] = tiny_engines.clean(Path(folder))
        return self.cleaned[key]


def told() -> str:
    """The counts, on one line."""
    names = ("histories", "steps", "commands", "jobs", "stale", "stuck", "needless", "followed")
    return ", ".join(f"{COUNTS[name]} {name}" for name in names)
