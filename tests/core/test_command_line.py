"""The command line itself: its version, its help, and how shells complete it."""

import shutil
import subprocess
import sys

import pytest

from foggy_synscapes import __version__, cli, commands
from foggy_synscapes.cli import main


def test_the_version_is_printed(capsys) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"foggy {__version__}\n"


def test_every_command_is_a_stage_and_explained() -> None:
    assert commands.words() == sorted({**cli.PIPELINE, **cli.TOOLS})
    for word in commands.words():
        stage, parser = commands.parser_of(word)
        assert stage.HELP
        assert "--params" in parser.format_help()


def test_help_sets_words_apart_from_what_they_do(capsys) -> None:
    assert main(["--help"]) == 0
    said = capsys.readouterr().out.split("\n")
    for word, text in {**cli.PIPELINE, **cli.TOOLS}.items():
        assert any(line.startswith(f"  {word} ") and text[:20] in line for line in said), word


def test_a_params_file_is_checked_that_stands_behind_the_option(capsys) -> None:
    assert main(["params", "--check", "nowhere.yaml"]) == 1
    assert "nowhere.yaml: missing" in capsys.readouterr().err


def completed(*words: str) -> list[str]:
    """What bash offers for the last of the words that stand on the command line."""
    script = subprocess.run(
        [sys.executable, "-m", "foggy_synscapes", "completion", "bash"], capture_output=True, text=True, check=True
    ).stdout
    script += f"COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}; _foggy\n"
    script += 'printf "%s\\n" "${COMPREPLY[@]}"'
    told = subprocess.run(["bash", "-euc", script], capture_output=True, text=True, check=True)
    assert told.stderr == ""
    return told.stdout.split()


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["foggy", "ad"], ["adopt"]),
        (["foggy", "--v"], ["--version"]),
        (["foggy", "fog", "--geo"], ["--geometry"]),
        (["foggy", "fog", "--geometry", ""], ["paper", "exact"]),
        (["foggy", "adopt", "--from", "d"], ["dvc"]),
        (["foggy", "completion", ""], ["bash", "zsh"]),
        (["foggy", "fog", "--out", ""], []),
    ],
)
def test_bash_completes_commands_options_and_values(words: list[str], wanted: list[str]) -> None:
    assert completed(*words) == wanted


@pytest.mark.skipif(shutil.which("zsh") is None, reason="there is no zsh here")
def test_zsh_reads_its_script() -> None:
    script = subprocess.run(
        [sys.executable, "-m", "foggy_synscapes", "completion", "zsh"], capture_output=True, text=True, check=True
    ).stdout
    assert subprocess.run(["zsh", "-fc", script], capture_output=True, text=True, check=True).stderr == ""
