"""Code counts by what it means: no comment, docstring or line break, but every value and operation."""

import ast
import random
from pathlib import Path

import pytest

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.provenance.source_digest import FOLDER, Loaded, code, meaning, now
from foggy_synscapes.registry import Registry, UnknownEntry, load_plugin

SOURCES = sorted(FOLDER.rglob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(FOLDER).as_posix())
def test_layout_comments_and_docstrings_do_not_count(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    # What unparse writes has no comment, other quotes, brackets and line breaks.
    assert meaning(ast.unparse(ast.parse(text)).encode()) == meaning(text.encode())
    assert meaning(b'"""Another docstring."""\n' + text.encode() + b"\n# A comment.\n") == meaning(text.encode())


class Change(ast.NodeTransformer):
    """Changes one node, chosen by its number: a number, a text that is used, an operator or a name."""

    def __init__(self, chosen: int) -> None:
        self.left, self.done = chosen, False

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return node  # a docstring
        if isinstance(node, ast.Constant | ast.BinOp | ast.Name):
            self.left -= 1
            if self.left < 0 and not self.done:
                self.done = True
                if isinstance(node, ast.Constant):
                    return ast.Constant("other" if node.value != "other" else "another")
                if isinstance(node, ast.Name):
                    return ast.Name(f"{node.id}_other", node.ctx)
                return ast.BinOp(node.right, ast.MatMult(), node.left)
        return self.generic_visit(node)


def test_every_constant_name_and_operation_counts() -> None:
    chosen = random.Random(3)
    for path in chosen.sample(SOURCES, 60):
        text = path.read_bytes()
        change = Change(chosen.randrange(40))
        try:
            other = ast.unparse(ast.fix_missing_locations(change.visit(ast.parse(text)))).encode()
        except ValueError:
            continue  # the change has no spelling, such as a text in place of a part of an f-string
        if change.done:
            assert meaning(other) != meaning(text), path


@pytest.mark.parametrize(
    ("one", "other"),
    [("x = 1", "x = 1.0"), ("x = True", "x = 1"), ("x = 'a'", "x = b'a'"), ("f(a=1)", "f(b=1)"), ("x = -1", "x = 1")],
)
def test_kinds_of_values_are_told_apart(one: str, other: str) -> None:
    assert meaning(one.encode()) != meaning(other.encode())


def plugin(folder: Path, name: str, text: str) -> None:
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.py").write_text(text)


def test_an_entry_counts_with_what_it_imports_and_no_other_entry(plugins: Path) -> None:
    things = Registry("networks", "THING", "thing")
    plugin(plugins, "one", "from foggy_plugins import shared\nimport mpmath\nTHING = shared.make()\n")
    plugin(plugins, "two", "THING = 2\n")
    plugin(plugins, "shared", "from foggy_synscapes.camera import Camera\nmake = Camera\n")
    before, libraries = code("filter", ("things.one",), {"things": things})
    assert {"foggy_plugins.one", "foggy_plugins.shared", "camera", "stages.filter"} <= before.keys()
    assert "foggy_plugins.two" not in before
    assert "mpmath" in libraries
    plugin(plugins, "two", "THING = 3\n")
    plugin(plugins, "one", "# A comment.\nfrom foggy_plugins import shared\nimport mpmath\nTHING = shared.make()\n")
    assert code("filter", ("things.one",), {"things": things})[0] == before
    plugin(plugins, "shared", "from foggy_synscapes.camera import Camera\nmake = Camera.__call__\n")
    after = code("filter", ("things.one",), {"things": things})[0]
    assert {name for name in after if after[name] != before[name]} == {"foggy_plugins.shared"}
    assert now("foggy_plugins.shared") == after["foggy_plugins.shared"]
    with pytest.raises(UnknownEntry, match=r"'three' is no thing; there are one, two"):
        code("filter", ("things.three",), {"things": things})


def test_what_a_record_names_and_is_gone_has_no_digest() -> None:
    assert now("stages.filter") == meaning((FOLDER / "stages/filter.py").read_bytes())
    assert now("stages.was_here_once") is None
    assert now("tables/published/nowhere.csv") is None


def test_a_module_that_is_edited_before_it_is_loaded_ends_the_job(plugins: Path) -> None:
    plugins.mkdir(exist_ok=True)
    (plugins / "late.py").write_text("import nowhere_to_be_found\n")
    loaded = Loaded(["foggy_plugins.late"])
    assert list(loaded.late) == ["foggy_plugins.late"]
    loaded.check()
    (plugins / "late.py").write_text("VALUE = 1  # another version\n")
    load_plugin(plugins / "late.py")
    with pytest.raises(FoggyError, match="edited before this command came to use it"):
        loaded.check()
