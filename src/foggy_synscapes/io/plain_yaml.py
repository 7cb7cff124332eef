"""YAML as plain data."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named, read_bytes

LARGEST = 1_000_000  # bytes; a complete params file has 17,000


# What YAML 1.1 takes for a number, a truth value or a date, and YAML 1.2 or a reader for something else: `1:30` is 90
# there, `1_0` is 10, `010` is 8, `on` is true.
PLAIN = re.compile(r"[-+]?(0|[1-9][0-9]*)|[-+]?[0-9]+\.[0-9]*([eE][-+]?[0-9]+)?|true|false|null|~|")
WORDS = ("tag:yaml.org,2002:str", "tag:yaml.org,2002:merge")


class _Loader(yaml.SafeLoader):
    """Plain data only: no tags, no aliases (which can grow), no key twice, nothing that may be read in two ways."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.events.AliasEvent):
            event = self.peek_event()
            raise yaml.constructor.ConstructorError(None, None, "aliases are not allowed in params", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> dict:
        seen = set()
        for place, value in node.value:
            key = self.construct_object(place, deep=deep)
            if isinstance(key, list | dict):
                raise yaml.constructor.ConstructorError(None, None, "a key must be a word", place.start_mark)
            if key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"key {key!r} stands twice", place.start_mark)
            seen.add(key)
            for odd in filter(_is_odd, (place, *_scalars(value))):
                text = f"{place.value}: {odd.value} is no plain number or word; quote it, or write it out"
                raise yaml.constructor.ConstructorError(None, None, text, odd.start_mark)
        return super().construct_mapping(node, deep)


def _scalars(node: yaml.Node) -> Iterator[yaml.Node]:
    """The values of a key, without those of the keys below it."""
    if isinstance(node, yaml.SequenceNode):
        for each in node.value:
            yield from _scalars(each)
    elif isinstance(node, yaml.ScalarNode):
        yield node


def _is_odd(node: yaml.Node) -> bool:
    """Whether a value is neither a word nor what is written plainly; one in quotes that is no word has a tag."""
    if not isinstance(node, yaml.ScalarNode) or node.tag in WORDS:
        return False
    return node.style is not None or PLAIN.fullmatch(node.value) is None


def read_yaml(path: str | Path) -> Any:
    """Read plain YAML: no tags, no aliases, no key twice. Raises FoggyError naming file and line."""
    data = read_bytes(path, "params file", "The default is params.yaml; others are in params/.", LARGEST)
    try:
        with named(path, "params file"):
            return yaml.load(data.decode("utf-8"), Loader=_Loader)
    except yaml.YAMLError as error:
        raise FoggyError(f"{path}: not a readable params file: {error}") from error
