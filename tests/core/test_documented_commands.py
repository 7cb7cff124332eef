"""Every command of the README and of the pages is one that there is; those that can run are run, on tiny files."""

import re
import shlex
import shutil
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import fog_frames
import numpy as np
import pytest

from foggy_synscapes import params as parameters
from foggy_synscapes.cli import PIPELINE, TOOLS, main
from foggy_synscapes.commands import parser_of
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.labels import from_train_ids
from foggy_synscapes.planning import asked
from foggy_synscapes.steps import steps

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md")]
PAGES += sorted(path for path in (ROOT / "docs").glob("*.md") if path.name not in ("commands.md", "parameters.md"))
# Programs of the commands that are not run here, and why.
NOT_RUN = {
    "snakemake": "takes minutes: its targets and params files are looked up instead; tests/workflow runs it",
    "dvc": "takes minutes, or needs a remote; tests/workflow runs it",
    "make": "sets up an environment or takes minutes: its targets are looked up instead",
    "pip": "needs a package index",
    "git": "needs the place that this was cloned from",
    "curl": "needs the web",
    "torchrun": "takes minutes; tests/stages/test_train_processes.py runs it",
    "tensorboard": "is a server",
    "docker": "needs a container engine",
    "apptainer": "needs a container engine",
    "conda": "needs conda",
    "pre-commit": "changes the hooks of a clone",
    "mkdir": "of the shell",
    ".": "of the shell",
    "cd": "of the shell",
    "eval": "changes the shell",
}
# Words of `foggy` that are not run here, and why; those of every other word are.
NOT_RUN_HERE = {
    "adopt": "needs a finished run; tests/workflow/test_adopt.py",
    "atlas": "traces paths for minutes",
    "card": "needs a finished run; tests/workflow/test_cards.py",
    "complete": "needs stereo pairs; tests/stages/test_complete.py",
    "croissant": "needs a finished run; tests/workflow/test_cards.py",
    "export": "needs a trained model; tests/stages/test_export.py",
    "scenes": "draws for a minute; tests/stages/test_scenes.py",
    "trace": "needs a finished run; tests/workflow/test_trace.py",
    "tradeoff": "measures for minutes; tests/stages/test_tradeoff.py",
    "unpack": "needs a shard; tests/stages/test_fog.py",
    "verify": "needs a finished run; tests/stages/test_verify.py",
    "weights": "needs public weights; tests/stages/test_weights.py",
}


def commands() -> Iterator[tuple[str, list[str]]]:
    """Page and words of each command line in a block of shell, comments left out; several in a line one by one."""
    for page in PAGES:
        for block in re.findall(r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            for line in block.replace("\\\n", " ").splitlines():
                for part in re.split(r" && | \| ", line.strip()):
                    words = shlex.split(part, comments=True)
                    while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]):
                        words = words[1:]
                    if words:
                        yield page.name, words


COMMANDS = list(dict.fromkeys((page, tuple(words)) for page, words in commands()))
RECIPES = "recipes.md"
"""Each command of this page is run by tests/stages/test_recipes.py, on files of its layout."""
OWN = [each for each in COMMANDS if each[1][0] == "foggy"]


def test_every_command_is_known_or_has_a_reason_not_to_be_run() -> None:
    assert len(OWN) > 30
    assert {words[0] for _, words in COMMANDS} <= {*NOT_RUN, "foggy"}
    assert {*NOT_RUN_HERE} <= {*PIPELINE, *TOOLS}


@pytest.mark.parametrize(("page", "words"), OWN, ids=lambda value: value if isinstance(value, str) else " ".join(value))
def test_the_command_line_takes_what_the_pages_say(page: str, words: tuple[str, ...]) -> None:
    if words[1].startswith("-"):
        assert words[1] in ("--version", "--help")
        return
    try:
        parser_of(words[1])[1].parse_args(words[2:])
    except SystemExit as stop:
        pytest.fail(f"{page}: {' '.join(words)}: exit status {stop.code}")


def test_words_in_the_text_are_commands() -> None:
    """`foggy WORD` in small letters between backticks."""
    for page in PAGES:
        for word in re.findall(r"`foggy ([a-z]+)", page.read_text(encoding="utf-8")):
            assert word in {**PIPELINE, **TOOLS}, f"{page.name}: foggy {word}"


def test_targets_of_make_and_snakemake_and_params_files_exist() -> None:
    makes = set(re.findall(r"^([\w./$(){}-]+(?: [\w./-]+)*):(?!=)", (ROOT / "Makefile").read_text(), re.MULTILINE))
    targets = {word for line in makes for word in line.split()} | {".venv/.ready"}
    named = {each.name for each in steps()} | {each.word for each in steps()} | {*asked.TARGETS, "all"}
    for page, words in COMMANDS:
        for word, after in pairwise(words):
            if word in ("--configfile", "--params", "--file") and after != "FILE":
                assert (ROOT / after).is_file(), f"{page}: {after}"
        plain = [
            word
            for before, word in pairwise(words)
            if not word.startswith("-") and not before.startswith("--") and "=" not in word and "/" not in word
        ]
        if words[0] == "snakemake":
            assert {*plain} <= named, f"{page}: {' '.join(words)}"
        if words[0] == "make":
            assert {word for word in plain if word.islower()} <= targets, f"{page}: {' '.join(words)}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tiny files under the names that the pages use, and the project's params."""
    folder = tmp_path_factory.mktemp("reader")
    for name in ("params", "params.yaml", "examples"):
        (folder / name).symlink_to(ROOT / name)
    (folder / "camera.json").write_text(fog_frames.camera_json())
    root = fog_frames.write_frames(folder / "ROOT", 3)
    (folder / "results/scenes").mkdir(parents=True)
    (folder / "results/scenes/synscapes").symlink_to(root)
    (folder / "img").symlink_to(root / "img")
    (folder / "IMAGES").symlink_to((root / synscapes.rgb(1)).parent)
    (folder / "DEPTHS").symlink_to((root / synscapes.depth(1)).parent)
    ids = np.arange(19, dtype=np.uint8).repeat(8).reshape(8, 19)
    for name, encoded in (("PREDICTIONS", ids), ("LABELS", from_train_ids(ids))):
        (folder / name).mkdir()
        write_bytes(folder / name / "street.png", encode_png(encoded))
    return folder


def _runs(words: tuple[str, ...]) -> bool:
    """Whether a command can be run here: neither a job of the pipeline, nor one that needs what is not there."""
    word = words[1]
    if word.startswith("-"):
        return True
    writes = "--out" in words and not words[words.index("--out") + 1].startswith(("params", "dvc"))
    places = {"DIR", "CITYSCAPES", "FILE", "RATE"} & {part.rpartition("=")[2] for part in words}
    alone = writes or word in ("plan", "networks", "steps", "params")
    return word not in NOT_RUN_HERE and alone and not places and "--dvc" not in words and "--check" not in words


@pytest.mark.parametrize(
    "words", sorted({words for page, words in OWN if page != RECIPES and _runs(words)}), ids=" ".join
)
def test_commands_that_can_run_do(
    folder: Path, words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(folder)
    shutil.rmtree(folder / "foggy", ignore_errors=True)  # several pages write to a folder of this name
    assert main([*words[1:]]) == 0, capsys.readouterr().err


def test_the_readmes_doors_print_what_it_says(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, tmp_path: Path
) -> None:
    """Fog on one's own frames: the line of the README, on two frames."""
    monkeypatch.chdir(folder)
    words = next(words for page, words in OWN if page == "README.md" and words[1] == "fog")
    out = words.index("--out") + 1
    assert main([*words[1:out], str(tmp_path / "foggy"), "--ids", "1,2"]) == 0
    printed = capsys.readouterr().out
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    (said,) = re.findall(r"`(fog: 2 frames[^`]*), \.\.\.`", readme)
    assert said in printed
    assert len(list((tmp_path / "foggy/beta_0.01/foggy_img").glob("*.png"))) == 2
    assert (tmp_path / "foggy/airlight.csv").is_file()
    assert parameters.load(folder / "params.yaml").fog.betas
