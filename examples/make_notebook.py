"""Run the cells of a notebook in plain Python and write what they print and draw into it: `make notebook`.

    python examples/make_notebook.py [--check] [FILE]

The file stays small and equal for equal results: figures are PNG of a stated size, without a date, and nothing says how
often or when a cell ran. With --check nothing is written, and the exit status is 1 where other text would come out, or
another number of figures.
"""

import argparse
import ast
import base64
import io
import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

NOTEBOOK = Path(__file__).with_name("fog_and_scores.ipynb")
DPI = 60


def outputs(source: str, names: dict[str, Any]) -> list[dict[str, Any]]:
    """Run a cell; what it prints, the value of its last expression, and its figures, as a notebook holds them."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    found: list[dict[str, Any]] = []
    if printed.getvalue():
        found.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        data = {"text/plain": lines(repr(value))}
        found.append({"data": data, "execution_count": None, "metadata": {}, "output_type": "execute_result"})
    for number in plt.get_fignums():
        image = io.BytesIO()
        plt.figure(number).savefig(image, format="png", dpi=DPI, metadata={"Software": None})
        data = {"image/png": base64.b64encode(image.getvalue()).decode() + "\n"}
        found.append({"data": data, "metadata": {}, "output_type": "display_data"})
    plt.close("all")
    return found


def lines(text: str) -> list[str]:
    """Text as notebooks hold it."""
    return text.splitlines(keepends=True)


def told(found: list[dict[str, Any]]) -> list[Any]:
    """What outputs say in words, and how many figures there are."""
    words = [each.get("text") or each["data"].get("text/plain") for each in found]
    return [word for word in words if word] + [sum("image/png" in each.get("data", {}) for each in found)]


def main(options: list[str] | None = None) -> int:
    """Run the notebook; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", type=Path, default=NOTEBOOK)
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args(options)
    document, names = json.loads(asked.file.read_text()), {"__name__": "__main__"}
    same = True
    for cell in document["cells"]:
        if cell["cell_type"] == "code":
            found = outputs("".join(cell["source"]), names)
            same = same and told(found) == told(cell["outputs"])
            cell["outputs"], cell["execution_count"] = found, None
    if asked.check:
        print(f"{asked.file}: {'as it is run' if same else 'not what its cells print now: run make notebook'}")
        return 0 if same else 1
    asked.file.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
