"""steps: the table of steps, for people or as the dvc.yaml that `dvc repro` runs."""

import argparse
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.jobs import PLACEHOLDER, Each, Step, Template, at
from foggy_synscapes.params import Params, load
from foggy_synscapes.planning.picture import workflow
from foggy_synscapes.results import CODE
from foggy_synscapes.steps import code_file, steps

HELP = "Show each kind of job: its command, what it reads and writes, and the params that decide it; or make dvc.yaml."
WIDTH = 110
HEAD = """\
# Made by `foggy steps --dvc dvc.yaml` from the table of steps; a test fails where it is not up to date.
# Stage `code` writes what the code of each job means, and the others compare that: a comment runs nothing.
"""
SOURCES = ("src/foggy_synscapes", "requirements.lock")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("--dvc", type=Path, metavar="FILE", help="write the stages of DVC: dvc.yaml")
    parser.add_argument("--svg", type=Path, metavar="FILE", help="draw the workflow: docs/images/workflow.svg")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    params = load(args.params)
    if args.svg is not None:
        write_text(args.svg, workflow())
        print(f"{args.svg}: the workflow")
    if args.dvc is None and args.svg is not None:
        return
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
    stages = {"code": _code_stage(params), **{step.name: _stage(step, params) for step in _staged(params)}}
    text = yaml.dump({"stages": stages}, Dumper=_Dumper, default_flow_style=None, sort_keys=False, width=WIDTH)
    return HEAD + re.sub(r"\n(?=  \w+:\n)", "\n\n", text)


class _Dumper(yaml.SafeDumper):
    """Repeats what occurs twice, as people write YAML."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _staged(params: Params) -> list[Step]:
    """Steps that become stages: those of which there are jobs. DVC refuses a list that params.yaml does not have."""
    return [step for step in steps() if step.default and step.all_values(params)]


def _code_stage(params: Params) -> dict[str, Any]:
    keys = ["plugins"]
    for step in filter(lambda step: step.default, steps()):
        keys += [step.wildcards[name] for name in step.code_wildcards()]
        keys += [entry.partition("*")[2] for entry in step.code if "*" in entry]
    return {
        "desc": "Write what counts of the code of each job.",
        "cmd": "foggy code",
        "deps": [*SOURCES, *([params.plugins] if params.plugins else [])],
        "params": [*dict.fromkeys(keys)],
        "outs": [{CODE: {"cache": False}}],
    }


def _stage(step: Step, params: Params) -> dict[str, Any]:
    own = code_file(step, {name: f"{{{name}}}" for name in step.code_wildcards()})
    inputs = [template.folder if isinstance(template, Each) else template for template in step.inputs.values()]
    shown = {*step.metrics, *step.plots}
    outputs = [template for name, template in step.outputs.items() if name not in shown and isinstance(template, str)]
    lists = {
        "deps": [own, *inputs],
        "params": step.keys(params),
        "outs": step.folders or outputs,
        "metrics": [_whole(step.outputs[name]) for name in step.metrics],
        "plots": [_whole(step.outputs[name]) for name in step.plots],
    }
    names = {name: f"item.{name}" for name in step.wildcards}
    if len(names) == 1:
        ((name, key),) = step.wildcards.items()
        names[name] = "key" if isinstance(at(params, key), Mapping) else "item"

    def spelt(template: str) -> str:
        """A template as DVC spells it."""
        return PLACEHOLDER.sub(lambda match: f"${{{f'item.{match[2]}' if match[2] else names[match[1]]}}}", template)

    stage: dict[str, Any] = {"desc": step.text, "cmd": f"foggy {spelt(step.command)}"}
    stage |= {word: [*dict.fromkeys(map(spelt, found))] for word, found in lists.items() if found}
    if step.plots:
        stage["plots"] = [{path: dict(of)} for path, of in zip(stage["plots"], step.plots.values(), strict=True)]
    if len(names) == 1:
        return {"foreach": f"${{{key}}}", "do": stage}
    return {"matrix": {name: f"${{{key}}}" for name, key in step.wildcards.items()}, **stage} if names else stage
