"""trace: what a result was made from, step by step, down to the index of the raw data."""

import argparse
import json
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.runs import read_runs, state

HELP = "Show, as a tree, the commands and files that a result was made from, and what on disk no longer matches."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("path", type=Path, help="a result, e.g. results/tables/foggy_zurich.tex")
    parser.add_argument("--json", action="store_true", help="print the tree as JSON")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    tree = trace(args.path)
    print(json.dumps(tree, indent=1) if args.json else "\n".join(_lines(tree)))


def trace(path: Path) -> dict[str, Any]:
    """Lineage of a file: its hash, its state on disk, the command that made it, and the same of its inputs.

    Raises
    ------
    FoggyError
        If no run record has the file among its outputs.
    """
    records = read_runs()
    makers = {output: record for record in records.values() for output in record["outputs"]}
    name = path.as_posix()
    if name not in makers:
        raise FoggyError(
            f"{name}: no run record has it among its outputs. Was it made by this pipeline, from this folder?"
        )
    return _node(name, makers[name]["outputs"][name], makers, set())


def _node(name: str, digest: str, makers: dict[str, dict], seen: set[str]) -> dict[str, Any]:
    node: dict[str, Any] = {"path": name, "sha256": digest, "state": state(name, digest)}
    maker = makers.get(name)
    if maker is None:
        return node
    node["command"] = " ".join(maker["command"])
    if maker["outputs"][name] != digest:
        # The consumer read other bytes than the last maker wrote: something ran in between, or by hand.
        node["state"] = "made again since it was read"
    if name in seen:
        node["shown_above"] = True
        return node
    seen.add(name)
    node |= {"params": maker["params"], "code": maker["code"], "versions": maker["versions"]}
    node["inputs"] = [_node(each, value, makers, seen) for each, value in maker["inputs"].items()]
    return node


def _lines(node: dict[str, Any], depth: int = 0) -> list[str]:
    mark = "" if node["state"] == "unchanged" else f"   <-- {node['state'].upper()}"
    line = f"{'  ' * depth}{node['path']}  {node['sha256'][:12]}{mark}"
    if "command" in node:
        line += f"\n{'  ' * depth}  by: {node['command']}" + ("  (shown above)" if node.get("shown_above") else "")
    return [line, *(text for child in node.get("inputs", ()) for text in _lines(child, depth + 1))]
