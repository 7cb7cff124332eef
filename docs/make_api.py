"""Write docs/api.md, the page of what a script or a notebook calls, from signatures and docstrings.

Run by `make schema` after a public docstring was edited; a test holds the page to the code.
"""

import ast
import inspect
import re
import textwrap
from importlib import import_module
from pathlib import Path

from foggy_synscapes.io.atomic import write_text

HEAD = """# Python API

What a script or a notebook calls, made from the docstrings by `make schema`. Names of the first part are imported from
the package itself (`from foggy_synscapes import fog`), those of the others from their modules. Arrays are in (row,
column) order, lengths in metres, beta in 1/m. The examples are run by `make test`; a notebook that uses them is
[fog_and_scores.ipynb](../examples/fog_and_scores.ipynb).
"""
# Modules whose public functions and classes are shown, by the heading that they stand under.
SHOWN = {
    "The package itself": ("api",),
    "Fog": ("fog.optics", "fog.geometry", "fog.airlight"),
    "Camera": ("camera",),
    "Scores": ("scoring.confusion", "scoring.iou"),
}
SETTING = re.compile(r"^(\w[\w, *]*) : (.*)$")


def page() -> str:
    """The whole page, in Markdown."""
    parts = [HEAD]
    for title, modules in SHOWN.items():
        parts.append(f"## {title}\n")
        for name in modules:
            module = import_module(f"foggy_synscapes.{name}")
            parts.append(f"### {module.__name__}\n\n{_markdown(module.__doc__ or '')}\n")
            parts += [_entry(entry) for entry in _public(module.__name__)]
    return "\n".join(parts)


def _public(module: str) -> list[ast.FunctionDef | ast.ClassDef]:
    """Functions and classes that a module defines for others, in its order, as they are written."""
    tree = ast.parse(Path(str(import_module(module).__file__)).read_bytes())
    kinds = (ast.FunctionDef, ast.ClassDef)
    return [node for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_")]


def _entry(node: ast.FunctionDef | ast.ClassDef) -> str:
    """Heading, signature as written, and docstring of a function, or of a class and its public methods."""
    parts = [f"#### {node.name}\n"]
    if isinstance(node, ast.FunctionDef):
        parts.append(_signature(node))
    parts.append(_markdown(ast.get_docstring(node) or ""))
    if isinstance(node, ast.ClassDef):
        fields = [ast.unparse(each) for each in node.body if isinstance(each, ast.AnnAssign)]
        if fields:
            parts.append("```python\n" + "\n".join(fields) + "\n```\n")
        methods = [each for each in node.body if isinstance(each, ast.FunctionDef) and not each.name.startswith("_")]
        parts += [f"{_signature(each)}\n{_markdown(ast.get_docstring(each) or '')}" for each in methods]
    return "\n".join(parts)


def _signature(node: ast.FunctionDef) -> str:
    """`def` line without its body; long ones with an argument a line."""
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    line = f"{node.name}({ast.unparse(node.args)}){returns}"
    if len(line) > 100:
        arguments = re.sub(r", (?=\*?\*?\w+[:,=]|\*|/)", ",\n    ", ast.unparse(node.args))
        line = f"{node.name}(\n    {arguments},\n){returns}"
    return f"```python\n{line}\n```\n"


def _markdown(docstring: str) -> str:
    """A docstring as Markdown: paragraphs as they are, lines `name : meaning` a list, doctests and formulas code."""
    blocks = []
    for block in re.split(r"\n\s*\n", inspect.cleandoc(docstring)):
        lines = block.splitlines()
        if len(lines) > 1 and set(lines[1]) == {"-"}:
            # A heading such as Parameters: the list below it says so by its form. Raises has an error, then its reason.
            title, lines = lines[0], lines[2:]
            if title == "Raises":
                lines = [f"Raises {' '.join(line.strip() for line in lines)}"]
            block = "\n".join(lines)
        if lines and lines[0].startswith(">>>"):
            blocks.append("```pycon\n" + block + "\n```")
        elif any(SETTING.match(line) for line in lines):
            blocks.append("\n".join(_item(line) for line in lines))
        elif all(line.startswith("    ") for line in lines):
            blocks.append("```\n" + textwrap.dedent(block) + "\n```")
        else:
            blocks.append(_escaped(block))
    return "\n\n".join(blocks) + "\n"


def _item(line: str) -> str:
    found = SETTING.match(line)
    return f"- `{found[1]}`: {_escaped(found[2])}" if found else f"  {_escaped(line.strip())}"


def _escaped(text: str) -> str:
    """Stars, underscores and brackets as they are; not in what is code already."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*_<>\[\]])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


if __name__ == "__main__":
    write_text(Path(__file__).parent / "api.md", page())
