"""One HTML file from a page's template, its style, its modules of JavaScript and its data."""

import html
import json
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

TEMPLATES = files("foggy_synscapes.view") / "templates"
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";$', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async )?(?:function|const) (\w+))", re.MULTILINE)
HOLES = re.compile(r"\{\{(\w+)\}\}")


def page(name: str, title: str, facts: Mapping[str, Any], blobs: Mapping[str, str]) -> str:
    """A page that needs no other file and no network.

    name : of its template and module; title : of the window
    facts : what its module reads as JSON; blobs : text by name, from `planes`, decoded when it is shown
    """
    data = json.dumps(facts, ensure_ascii=False, sort_keys=True, separators=(",", ":")).replace("<", "\\u003c")
    held = [f'<script type="text/plain" id="blob-{html.escape(key)}">{text}</script>' for key, text in blobs.items()]
    parts = {
        "title": html.escape(title),
        "style": _read("view.css"),
        "facts": f'<script type="application/json" id="facts">{data}</script>',
        "blobs": "\n".join(held),
        "script": f'<script type="module">\n{script(name)}</script>',
    }
    return HOLES.sub(lambda hole: parts[hole[1]], _read(f"{name}.html"))


def script(name: str) -> str:
    """A module with those that it imports before it, as one: a page from disk may not load others.

    Each is a function that is called at once, so that its names are its own, and gives what it exports.
    """
    order: dict[str, str] = {}

    def visit(each: str) -> None:
        if each not in order:
            text = _read(f"{each}.js")
            for _, found in IMPORT.findall(text):
                visit(found)
            exported = ", ".join(EXPORT.findall(text))
            body = EXPORT.sub("", IMPORT.sub(r"const \1 = \2_module;", text))
            order[each] = f"const {each}_module = (() => {{\n{body}return {{ {exported} }};\n}})();\n"

    visit(name)
    return "".join(order.values())


def _read(name: str) -> str:
    return (TEMPLATES / name).read_text("utf-8")
