"""What each way of installing brings: the held list, and what the metadata of installed packages say."""

import json
import re
import tomllib
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
HELD = Path(__file__).with_name("doors.json")
BARE = "bare"
"""The door without an extra: fog and scores."""
MOST_PACKAGES, MOST_MEGABYTES = 13, 400
"""What fog and scores may bring."""
# What PyTorch's builds for CUDA bring beside it: which of them, the build decides.
OF_CUDA = re.compile(r"nvidia-.*|cuda-.*|triton")


def held() -> dict[str, list[str]]:
    """Third-party packages by door, without what PyTorch's build decides."""
    return json.loads(HELD.read_text())


def asked(door: str) -> list[str]:
    """Requirements that pyproject.toml states for a door."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return project["dependencies"] + ([] if door == BARE else project["optional-dependencies"][door])


def resolved(door: str) -> list[str]:
    """All packages that a door asks for, and those that they ask for, as the metadata of the installed ones say."""
    found: set[tuple[str, str]] = set()
    waiting = [Requirement(text) for text in asked(door)]
    while waiting:
        requirement = waiting.pop()
        for extra in sorted({"", *requirement.extras}):
            name = canonical(requirement.name)
            if (name, extra) not in found:
                found.add((name, extra))
                waiting += [
                    each
                    for each in map(Requirement, metadata.requires(name) or [])
                    if each.marker is None or each.marker.evaluate({"extra": extra})
                ]
    return without_cuda({name for name, _ in found})


def without_cuda(names: set[str]) -> list[str]:
    """Names, sorted, without the libraries of CUDA."""
    return sorted(name for name in names if not OF_CUDA.fullmatch(name))


def canonical(name: str) -> str:
    """The one spelling of a distribution's name."""
    return re.sub(r"[-_.]+", "-", name).lower()
