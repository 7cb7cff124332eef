"""Imports run one way, between every two packages, checked on the syntax tree."""

import ast
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src/foggy_synscapes"
PACKAGE = "foggy_synscapes"
# From the lowest up: a package or module imports those before it, and no later one.
ORDER = (
    "errors",
    "labels",
    "betas",
    "camera",
    "jit",
    "io",
    "registry",
    "schema",
    "fog",
    "depth",
    "networks",
    "scoring",
    "training",
    "stability",
    "datasets",
    "standin",
    "subsets",
    "figures",
    "params",
    "results",
    "frames",
    "api",
    "tables",
    "atlas",
    "tradeoff",
    "view",
    "jobs",
    "stereo_steps",
    "step_files",
    "measured_steps",
    "steps",
    "planning",
    "provenance",
    "commands",
    "stages",
    "cli",
    "__main__",
)


def imported(path: Path) -> set[str]:
    """Packages and modules right below the project's that a file imports, inside functions too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: write the whole name"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            # `from foggy_synscapes import __version__`: a name of the top package, which imports nothing.
            if parts[0] == PACKAGE and len(parts) > 1 and not parts[1].startswith("__"):
                found.add(parts[1])
    return found


def rooms() -> dict[str, set[str]]:
    """What each package or module below the project's imports of the others."""
    found: dict[str, set[str]] = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        if parts != ("__init__",):
            found.setdefault(parts[0], set()).update(imported(path) - {parts[0]})
    return found


def test_every_room_has_its_place() -> None:
    assert sorted(rooms()) == sorted(ORDER)


def test_imports_run_downwards_only() -> None:
    upwards = [
        f"{room} imports {other}"
        for room, others in rooms().items()
        for other in sorted(others)
        if ORDER.index(other) >= ORDER.index(room)
    ]
    assert upwards == []


def test_no_stage_imports_a_stage() -> None:
    for path in sorted((SOURCE / "stages").glob("*.py")):
        assert "stages" not in imported(path), path


def test_cores_know_no_path() -> None:
    cores = ("fog", "depth", "networks", "training", "stability")
    for core in cores:
        for path in sorted((SOURCE / core).rglob("*.py")):
            names = {
                node.names[0].name for node in ast.walk(ast.parse(path.read_bytes())) if isinstance(node, ast.Import)
            }
            assert "pathlib" not in names, path
