"""Changes of a finished smoke run, and the exact jobs that each must make run again.

Jobs are named as in `engines.job`; a pattern may hold `*`. What is listed is meant to be checked by hand against the
README's picture of the steps, so it is written out here, not derived from the code that it tests.
"""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from engines import complete

from foggy_synscapes.io.atomic import write_text

PARAMS = "params"
"""Stands for the params files of a clone, completed: params/smoke.yaml, and params.yaml where DVC runs."""
FS_498 = " FS-498: {train: 6, validation: 4, beta: "
PURE = ("FS-24500", "FS-498", "FC-FS-498")
FRAMES = ("figures beta_strip", "figures fc_against_fs")
SCORED = ("tables *", "figures curves", "figures predictions_*", "figures class_change_*", "figures confusion_*")
STAND_IN = "the engine that sees a drawn file changed has it drawn again; its index stays as it was"
FOLDERS = "DVC cannot list files by pattern: a step that gathers many depends on their folder, run records included"
LAZY = "Snakemake makes a lost file again when a job needs it, and `foggy verify` names it; DVC restores it at once"


def rows(*names: str) -> tuple[str, ...]:
    """Jobs from a list that changed to the tables."""
    return (*(f"{word} {name} *" for row in names for word, name in _of_row(row)), *SCORED)


def _of_row(row: str) -> Iterator[tuple[str, str]]:
    yield "train", f"* {row}"
    yield "evaluate", f"* {row}"


@dataclass(frozen=True)
class Edit:
    """One edited file: `old` text becomes `new`; without `old`, `new` is appended; without both, it is deleted."""

    path: str
    old: str | None = None
    new: str | None = None
    touch: bool = False


@dataclass(frozen=True)
class Change:
    """What is changed, the jobs that are out of date at once, and those that follow because contents change.

    snakemake, dvc : what an engine finds out of date instead, where that cannot be avoided; `dvc_follow` also follows
    options : of Snakemake
    restored : jobs that DVC finds out of date, but does not run: it takes their outputs from its cache, or finds what
        they read restored
    """

    name: str
    edits: tuple[Edit, ...]
    direct: tuple[str, ...] = ()
    follow: tuple[str, ...] = ()
    snakemake: tuple[str, ...] | None = None
    dvc: tuple[str, ...] | None = None
    dvc_follow: tuple[str, ...] | None = None
    restored: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    note: str = ""


def edit_params(old: str, new: str) -> tuple[Edit, ...]:
    """An edit of the params file."""
    return (Edit(PARAMS, old, new),)


def edit_code(path: str, old: str | None = None, new: str = "\n# A comment.\n") -> tuple[Edit, ...]:
    """An edit of a source file; by itself, one that changes no result."""
    return (Edit(f"src/foggy_synscapes/{path}", old, new),)


FOG_WORDS = ("fog *", "figures *", "stability")
CHANGES = (
    Change(
        "a beta added, for FS-498",
        (
            *edit_params('betas: ["0.005"]', 'betas: ["0.005", "0.01"]'),
            *edit_params(f'{FS_498}"0.005"', f'{FS_498}"0.01"'),
        ),
        direct=("fog 0.01 *", "subset FS-498", "tables *"),
        follow=rows("FS-498"),
    ),
    Change(
        "another beta everywhere",
        (
            *edit_params('betas: ["0.005"]', 'betas: ["0.01"]'),
            *(
                edit
                for row in ("FS-24500: {train: 12, validation: 4, beta: ", FS_498, "FC-" + FS_498.strip() + " ")
                for edit in edit_params(f'{row}"0.005"', f'{row}"0.01"')
            ),
        ),
        direct=("fog 0.01 *", *(f"subset {row}" for row in PURE), "tables *"),
        follow=rows(*PURE),
    ),
    Change(
        "number of images of one row",
        edit_params(FS_498, FS_498.replace("train: 6", "train: 5")),
        direct=("subset FS-498", "tables *"),
        follow=rows("FS-498"),
    ),
    Change(
        "mix ratio",
        edit_params("ratio: [2, 1]", "ratio: [1, 1]"),
        direct=("subset FC-FS-498", "tables *"),
        follow=rows("FC-FS-498"),
    ),
    Change(
        "learning rate of BiSeNet's fine-tuning",
        edit_params("learning_rate: 0.001\n", "learning_rate: 0.003\n"),
        direct=("train bisenet F*",),
        follow=("evaluate bisenet F*", *SCORED),
    ),
    Change(
        "learning rate of RefineNet's baseline",
        edit_params("learning_rate: 0.02\n", "learning_rate: 0.03\n"),
        direct=("train refinenet C 0",),
        follow=("train refinenet F*", "evaluate refinenet *", *SCORED),
    ),
    Change(
        "length of one row",
        edit_params("FC-498: {length: {epochs: 1}", "FC-498: {length: {epochs: 2}"),
        direct=("train * FC-498 0",),
        follow=("evaluate * FC-498 *", *SCORED),
    ),
    Change(
        "a second seed",
        edit_params('seeds: ["0"]', 'seeds: ["0", "1"]'),
        direct=("train * 1", "evaluate * 1 *", *SCORED),
    ),
    Change(
        "geometry of the fog",
        edit_params("geometry: paper", "geometry: exact"),
        direct=("fog 0.005 *", *FRAMES),
        follow=(*(f"subset {row}" for row in PURE), *rows(*PURE)),
    ),
    Change(
        "a filter rule that keeps every frame",
        edit_params("maximum: 5.0}\n", "maximum: 5.0}\n    - {key: num_cars, minimum: 0}\n"),
        direct=("filter", "figures sky_contrast"),
    ),
    Change(
        "number of test images of Foggy Zurich",
        edit_params("foggy_zurich: 5", "foggy_zurich: 6"),
        direct=("scenes foggy_zurich",),
        follow=("evaluate * foggy_zurich", "tables foggy_zurich", "figures *_foggy_zurich"),
    ),
    Change(
        "a row's label in the tables",
        edit_params("fine_tuning: FC, images", "fine_tuning: Foggy Cityscapes, images"),
        direct=("tables *", "figures curves", "figures *_foggy_*"),
    ),
    Change("images held in memory while training", edit_params("cache: 256", "cache: 128")),
    Change("a comment in the params file", (Edit(PARAMS, None, "\n# A comment.\n"),)),
    Change(
        "code of the fog",
        edit_code("fog/kernel.py", "math.sqrt((row + column) / scale)", "1.1 * math.sqrt((row + column) / scale)"),
        direct=FOG_WORDS,
        follow=(*(f"subset {row}" for row in PURE), *rows(*PURE)),
    ),
    Change(
        "code of the fog that computes the same",
        edit_code(
            "fog/optics.py", "    return CONTRAST / _attenuation(beta", "    return +CONTRAST / _attenuation(beta"
        ),
        direct=FOG_WORDS,
        dvc_follow=tuple(f"subset {row}" for row in PURE),
        note=FOLDERS,
    ),
    Change("a comment in the code of the fog", edit_code("fog/optics.py")),
    Change(
        "code of a loss",
        edit_code("training/losses.py", "return losses.sum() /", "return 1.5 * losses.sum() /"),
        direct=("train *", "stability"),
        follow=("evaluate *", *SCORED),
    ),
    Change("a comment in the code of a loss", edit_code("training/losses.py")),
    Change(
        "code of RefineNet's layers that computes the same",
        edit_code("networks/refinenet_layers.py", "nn.Dropout(0.5)", "nn.Dropout(1 / 2)"),
        direct=("train refinenet *", "evaluate refinenet *", "tables *", "figures *_foggy_*"),
        dvc_follow=("figures curves",),
        note=FOLDERS,
    ),
    Change(
        "code of a table: its caption",
        edit_code("tables/ours.py", "IoU in percent. {ABB", "IoU in %. {ABB"),
        direct=("tables *",),
    ),
    Change("a comment in the code of a table", edit_code("tables/ours.py")),
    Change(
        "a published number",
        edit_code("tables/published/foggy_zurich.csv", "74.3,56.5", "74.4,56.5"),
        direct=("tables *",),
    ),
    Change(
        "code of the filter that computes the same",
        edit_code("stages/filter.py", "    if kept.empty:", "    if not len(kept):"),
        direct=("filter",),
    ),
    Change("a comment in the code of the stand-in", edit_code("standin/street.py")),
    Change("a docstring of the params schema", edit_code("params/scenes.py", '"""Which frames', '"""The frames that')),
    Change("another version number", edit_code("__init__.py", '__version__ = "', '__version__ = "9.')),
    Change(
        "a new key of a figure, with a default",
        edit_code(
            "params/experiment.py",
            "    comparison_beta: Beta",
            '    colours: int = setting("shown", default=2)\n    comparison_beta: Beta',
        ),
        direct=("figures *",),
        dvc=(),
        note="DVC reads params.yaml as it stands; completed by `foggy params`, it has the key, and DVC the same jobs",
    ),
    Change(
        "a table deleted",
        (Edit("results/tables/foggy_zurich.tex"),),
        direct=("tables foggy_zurich",),
        restored=("tables foggy_zurich",),
    ),
    Change(
        "a list deleted",
        (Edit("results/subset/C/train.csv"),),
        direct=("subset C",),
        snakemake=(),
        dvc=("subset C", "train * C 0"),
        restored=("subset C", "train * C 0"),
        note=LAZY,
    ),
    Change(
        "a fog shard deleted",
        (Edit("results/fog/beta_0.005/0000.tar"),),
        direct=("fog 0.005 0000",),
        snakemake=(),
        dvc=("fog 0.005 0000", *(f"subset {row}" for row in PURE)),
        restored=("fog 0.005 0000", *(f"subset {row}" for row in PURE)),
        note=LAZY,
    ),
    Change(
        "a table altered by hand",
        (Edit("results/tables/foggy_zurich.tex", None, "% by hand\n"),),
        direct=("tables foggy_zurich",),
        restored=("tables foggy_zurich",),
    ),
    Change(
        "time stamps touched: a list, a model, an index, a source file",
        tuple(
            Edit(path, touch=True)
            for path in (
                "results/subset/C/train.csv",
                "results/train/bisenet/C/seed-0/model.safetensors",
                "results/scenes/index/synscapes/0000.csv",
                "src/foggy_synscapes/fog/optics.py",
            )
        ),
    ),
    Change(
        "a stage renamed",
        (
            *edit_code("steps.py", 'name="filter",', 'name="keep",'),
            Edit("dvc.yaml", "  filter:\n    desc", "  keep:\n    desc"),
            Edit("dvc.yaml", "results/code/filter.txt", "results/code/keep.txt"),
        ),
        direct=("filter",),
        snakemake=(),
    ),
    Change("another number of cores", (), options=("--cores", "7")),
)


def matching(jobs: Iterable[str], patterns: Iterable[str]) -> set[str]:
    """The jobs that a pattern names; a pattern that names none is an error of the table."""
    jobs, found = list(jobs), set()
    for pattern in patterns:
        named = {name for name in jobs if fnmatchcase(name, pattern)}
        assert named, f"no job is named {pattern!r}; there are {sorted(jobs)}"
        found |= named
    return found


@contextmanager
def changed(folder: Path, change: Change, spare: Path) -> Iterator[None]:
    """Make a change in a clone, and take it back at the end, times included; `spare` is an empty folder."""
    kept: list[tuple[Path, Path]] = []
    for number, (path, _) in enumerate(_files(folder, change)):
        if all(path != other for other, _ in kept):
            shutil.copy2(path, spare / str(number))
            kept.append((path, spare / str(number)))
    make(folder, change)
    try:
        yield
    finally:
        for path, copy in kept:
            shutil.copy2(copy, path)


def make(folder: Path, change: Change) -> None:
    """Make a change in a clone, for good."""
    files = _files(folder, change)
    # An overlay may not state what an edit looks for; completed, it asks for the same.
    for path in dict.fromkeys(path for path, edit in files if edit.path == PARAMS):
        write_text(path, complete(path))
    for path, edit in files:
        apply(path, edit)


def _files(folder: Path, change: Change) -> list[tuple[Path, Edit]]:
    files = []
    for edit in change.edits:
        names = ["params/smoke.yaml", *(["params.yaml"] if (folder / ".git").is_dir() else [])]
        files += [(folder / name, edit) for name in (names if edit.path == PARAMS else [edit.path])]
    return files


def apply(path: Path, edit: Edit) -> None:
    """Edit one file; a text that is not there is an error."""
    if edit.touch:
        os.utime(path)
    elif edit.new is None:
        path.unlink()
    else:
        text = path.read_text(encoding="utf-8")
        assert edit.old is None or edit.old in text, f"{path}: has no {edit.old!r}"
        path.unlink()  # a cache may share its bytes
        path.write_text(text + edit.new if edit.old is None else text.replace(edit.old, edit.new), encoding="utf-8")
