"""completion: a script by which a shell completes the commands and options of `foggy`, made of their own parsers."""

import argparse
from collections.abc import Mapping
from shlex import quote

from foggy_synscapes import commands

HELP = (
    "Print a script that lets a shell complete commands, options and their values. For bash, in ~/.bashrc: "
    'eval "$(foggy completion bash)"; for zsh, in ~/.zshrc: eval "$(foggy completion zsh)".'
)
SHELLS = ("bash", "zsh")
BEGIN = {"bash": "", "zsh": "autoload -U +X compinit bashcompinit && compinit && bashcompinit\n"}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("shell", choices=SHELLS, help="that is to complete")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    parsers: dict[str, argparse.ArgumentParser | None] = {}
    for word in commands.words():
        try:
            parsers[word] = commands.parser_of(word)[1]
        except ModuleNotFoundError:  # of the commands whose packages are not installed, the names are completed
            parsers[word] = None
    print(script(args.shell, parsers), end="")


def script(shell: str, parsers: Mapping[str, argparse.ArgumentParser | None]) -> str:
    """The script for a shell; where nothing is to be completed, names of files are.

    >>> parser = argparse.ArgumentParser()
    >>> _ = parser.add_argument("--geometry", choices=["paper", "exact"])
    >>> print([line.strip() for line in script("bash", {"fog": parser}).splitlines() if "paper" in line][0])
    "fog --geometry") words='paper exact';;
    """
    values, options = [], []
    for word, parser in parsers.items():
        actions = parser._actions if parser is not None else []  # argparse has no public way to list them
        for action in actions:
            # A value stands after its option, a positional one after the command.
            for before in (action.option_strings or [word]) if action.choices is not None else ():
                chosen = quote(" ".join(map(str, action.choices or ())))
                values.append(f'        "{word} {before}") words={chosen};;')
        named = " ".join(name for action in actions for name in action.option_strings)
        options.append(f"        {word}) words={quote(named)};;")
    lines = [
        "_foggy() {",
        '    local word="${COMP_WORDS[1]}" current="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}"',
        "    local words=",
        "    COMPREPLY=()",
        '    if [ "$COMP_CWORD" -eq 1 ]; then',
        f"        words={quote(' '.join([*parsers, '--help', '--version']))}",
        '    else case "$word $before" in',
        *values,
        '        *) case "$current" in -*) case "$word" in',
        *(f"        {line}" for line in options),
        "        esac;; esac;;",
        "    esac; fi",
        '    if [ -n "$words" ]; then COMPREPLY=($(compgen -W "$words" -- "$current")); fi',
        "}",
        "complete -o default -F _foggy foggy",
    ]
    return BEGIN[shell] + "\n".join(lines) + "\n"
