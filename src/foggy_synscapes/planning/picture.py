"""The workflow as a picture: a box for each word of the experiment, an arrow where one reads what another writes."""

import re

from foggy_synscapes.io.svg import Box, drawing
from foggy_synscapes.jobs import PLACEHOLDER, Step, Template
from foggy_synscapes.steps import steps

WRITES = {
    "scenes": ("lists of datasets,", "sample data"),
    "filter": ("frames that are kept",),
    "complete": ("depth from stereo",),
    "fog": ("airlight,", "foggy images"),
    "subset": ("training lists",),
    "train": ("networks",),
    "evaluate": ("IoU, predictions",),
    "tables": ("tables of mean IoU",),
    "figures": ("figures",),
}
"""What comes out of each word, in lines of a box."""


def workflow() -> str:
    """The words of the whole experiment that read from each other, as SVG.

    An arrow is left out where others lead the same way: what is read from two steps before is not drawn.
    """
    of_word: dict[str, list[Step]] = {}
    for step in steps():
        if step.default:
            of_word.setdefault(step.word, []).append(step)
    pairs = {
        (one, other)
        for one, makers in of_word.items()
        for other, readers in of_word.items()
        if one != other and any(_reads(reader, maker) for reader in readers for maker in makers)
    }
    boxes = {
        word: Box(word, WRITES[word], f"foggy {word}: " + " ".join(step.text for step in found))
        for word, found in of_word.items()
        if any(word in pair for pair in pairs)
    }
    return drawing(boxes, _direct(pairs), "The steps of the experiment, from datasets to tables and figures")


def _reads(reader: Step, maker: Step) -> bool:
    return any(
        _same(one, other)
        for one in map(_whole, reader.inputs.values())
        for other in map(_whole, maker.outputs.values())
    )


def _whole(template: Template) -> str:
    return template if isinstance(template, str) else f"{template.folder}/{template.files}"


def _same(one: str, other: str) -> bool:
    """Whether two templates have a file in common, whatever their wildcards are."""

    def fits(pattern: str, text: str) -> bool:
        parts = PLACEHOLDER.split(pattern)[::3]  # what stands between placeholders
        return re.fullmatch("[^/]+".join(map(re.escape, parts)), PLACEHOLDER.sub("x", text)) is not None

    return fits(one, other) or fits(other, one)


def _direct(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Pairs that no chain of others stands for."""

    def leads(one: str, other: str) -> bool:
        return any(a == one and (b == other or leads(b, other)) for a, b in pairs)

    return {(a, b) for a, b in pairs if not any(x == a and y != b and leads(y, b) for x, y in pairs)}
