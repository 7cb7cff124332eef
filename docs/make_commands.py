"""Write docs/commands.md, the page of all commands and options, from the parsers of the command line itself.

Run by `make schema` after an option was added or its help edited; a test holds the page to the parsers.
"""

import argparse
import re
from pathlib import Path

from foggy_synscapes.cli import PIPELINE, TOOLS
from foggy_synscapes.commands import parser_of
from foggy_synscapes.io.atomic import write_text

HEAD = """# Commands

Every command of `foggy`, made from the command line's own parsers by `make schema`. `foggy COMMAND --help` prints the
same in the terminal. Each command also takes `--params FILE` (the params file; default: `params.yaml`) and `--debug`
(show the traceback of an error). `foggy --version` prints the version.

Exit status: 0 where all went well, 1 where the work failed, 2 where the call was wrong. An error is one message on the
standard error stream that says what is wrong, where, and what to do.

A command called without `--out` does one job of the pipeline as the params describe it, and writes below `results/`.
"""
COMMON = ("help", "params", "debug")


def page() -> str:
    """The whole page, in Markdown."""
    parts = [HEAD]
    for title, words in (("The steps of the experiment", PIPELINE), ("Tools", TOOLS)):
        parts.append(f"## {title}\n")
        for word in words:
            parts += [f"### foggy {word}\n", *_command(parser_of(word)[1])]
    return "\n".join(parts)


def _command(parser: argparse.ArgumentParser) -> list[str]:
    """What a parser says of its command, a table for each group of its options, and its sub-commands."""
    lines = [f"{_escaped(parser.description)}\n"] if parser.description else []
    formatter = parser._get_formatter()
    below: list[tuple[str, argparse.ArgumentParser]] = []
    for group in parser._action_groups:
        rows = []
        for action in group._group_actions:
            if isinstance(action, argparse._SubParsersAction):
                below += action.choices.items()
            elif action.dest not in COMMON and action.help != argparse.SUPPRESS:
                needed = "**required**; " if action.required and action.option_strings else ""
                rows.append(f"| {_spelling(action)} | {needed}{_escaped(formatter._expand_help(action))} |")
        if rows:
            title = {"options": "", "positional arguments": ""}.get(group.title or "", group.title or "")
            said = ": ".join(text for text in (title, group.description or "") if text)
            lines += [f"{_sentence(_escaped(said))}\n"] if said else []
            lines += ["| option | meaning |", "| --- | --- |", *rows, ""]
    for name, each in below:
        lines += [f"#### {parser.prog} {name}\n", *_command(each)]
    return lines


def _spelling(action: argparse.Action) -> str:
    """How an option or argument is written on the command line."""
    value = action.metavar or (f"{{{','.join(map(str, action.choices))}}}" if action.choices else action.dest.upper())
    if not action.option_strings:
        return f"`{value}`"
    value = "" if action.nargs == 0 else f" {value}"
    return ", ".join(f"`{option}{value}`" for option in action.option_strings)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", ":")) else ".")


def _escaped(text: str) -> str:
    """Text of the parsers in Markdown: words in capitals and file patterns as they are, nothing taken for markup."""
    return re.sub(r"([*_<>|\[\]])", r"\\\1", " ".join(text.split()))


if __name__ == "__main__":
    write_text(Path(__file__).parent / "commands.md", page())
