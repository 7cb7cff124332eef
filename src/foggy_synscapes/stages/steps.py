"""steps: the table of steps, for people or as the dvc.yaml that `dvc repro` runs."""

import argparse
import json
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.jobs import PLACEHOLDER, Each, Step, Template, at
from foggy_synscapes.params import Params, load
from foggy_synscapes.results import CODE
from foggy_synscapes.steps import code_file, steps

HELP = "Show each kind of job: its command, what it reads and writes, and the params that decide it; or make dvc.yaml."
WIDTH = 120
PLAIN = re.compile(r"[A-Za-z][\w./-]*")  # what YAML takes for text without quotes
SOURCES = ("src/foggy_synscapes", "requirements.lock")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("--dvc", type=Path, metavar="FILE", help="write the stages of DVC: dvc.yaml")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    params = load(args.params)
    if args.dvc is None:
        print("\n".join(line for step in steps() for line in described(step)))
        return
    write_text(args.dvc, dvc_yaml(params))
    print(f"{args.dvc}: {len(_staged(params)) + 1} stages")


def described(step: Step) -> Iterator[str]:
    """A kind of job in a few lines."""
    yield f"{step.name}: {step.text}"
    yield f"  foggy {step.command}"
    for name, key in step.wildcards.items():
        yield f"  {{{name}}}: each of {key}"
    for word, templates in (("reads", step.inputs), ("writes", step.outputs)):
        if templates:
            yield f"  {word}: {', '.join(_whole(template) for template in templates.values())}"
    if step.params:
        yield f"  params: {', '.join(step.params)}"


def _whole(template: Template) -> str:
    return template if isinstance(template, str) else f"{template.folder}/{template.files}"


def dvc_yaml(params: Params) -> str:
    """The text of dvc.yaml: the stages of the whole experiment, whose lists follow params.yaml when DVC reads it.

    params : tell which wildcards are lists and which are mappings, and the folder of plugins
    """
    lines = [
        "# Made by `foggy steps --dvc dvc.yaml` from the table of steps; a test fails where it is not up to date.",
        "# Stage `code` writes what the code of each job means, and the others compare that: a comment runs nothing.",
        "stages:",
        *_code_stage(params),
    ]
    for step in _staged(params):
        lines += ["", *_stage(step, params)]
    return "\n".join(lines) + "\n"


def _staged(params: Params) -> list[Step]:
    """Steps that become stages: those of which there are jobs. DVC refuses a list that params.yaml does not have."""
    return [step for step in steps() if step.default and step.all_values(params)]


def _code_stage(params: Params) -> Iterator[str]:
    keys = {"plugins": None}
    for step in steps():
        keys |= {step.wildcards[name]: None for name in step.code_wildcards() if step.default}
        keys |= {entry.partition("*")[2]: None for entry in step.code if "*" in entry and step.default}
    yield "  code:"
    yield "    desc: Write what counts of the code of each job."
    yield "    cmd: foggy code"
    yield from _list("deps", [*SOURCES, *([params.plugins] if params.plugins else [])], "    ")
    yield from _list("params", keys, "    ")
    yield f"    outs: [{CODE}: {{cache: false}}]"


def _stage(step: Step, params: Params) -> Iterator[str]:
    spelt = _Spelling(step, params)
    yield f"  {step.name}:"
    indent = "    "
    if len(step.wildcards) == 1:
        (key,) = step.wildcards.values()
        yield f"    foreach: ${{{key}}}"
        yield "    do:"
        indent = "      "
    elif step.wildcards:
        yield "    matrix:"
        yield from (f"      {name}: ${{{key}}}" for name, key in step.wildcards.items())
    yield f"{indent}desc: {json.dumps(step.text, ensure_ascii=False)}"
    yield f"{indent}cmd: foggy {spelt(step.command)}"
    own = code_file(step, {name: f"{{{name}}}" for name in step.code_wildcards()})
    inputs = [template.folder if isinstance(template, Each) else template for template in step.inputs.values()]
    yield from _list("deps", map(spelt, [own, *inputs]), indent)
    if step.params:
        yield from _list("params", map(spelt, step.keys(params)), indent)
    shown = {*step.metrics, *step.plots}
    outputs = [template for name, template in step.outputs.items() if name not in shown and isinstance(template, str)]
    yield from _list("outs", map(spelt, step.folders or outputs), indent)
    for kind, names in (("metrics", step.metrics), ("plots", step.plots)):
        if names:
            yield from _list(kind, (spelt(_whole(step.outputs[name])) for name in names), indent, step.plots)


class _Spelling:
    """Templates of a step as DVC spells them."""

    def __init__(self, step: Step, params: Params) -> None:
        self.names: dict[str, str] = {name: f"item.{name}" for name in step.wildcards}
        if len(step.wildcards) == 1:
            ((name, key),) = step.wildcards.items()
            self.names[name] = "key" if isinstance(at(params, key), Mapping) else "item"

    def __call__(self, template: str) -> str:
        def spell(match: re.Match) -> str:
            name, attribute = match.groups()
            return f"${{item.{attribute}}}" if attribute else f"${{{self.names[name]}}}"

        return PLACEHOLDER.sub(spell, template)


def _list(
    key: str, values: Iterable[str], indent: str, settings: Mapping[str, Mapping[str, str]] | None = None
) -> Iterator[str]:
    """A list, on as many lines as it takes."""
    quoted = [value if PLAIN.fullmatch(value) else json.dumps(value) for value in dict.fromkeys(values)]
    (more,) = {json.dumps(each) for each in (settings or {}).values() if each} or {""}
    if key == "plots" and more:
        quoted = [f"{value}: {more}" for value in quoted]
    yield from textwrap.wrap(
        f"{key}: [{', '.join(quoted)}]",
        WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
