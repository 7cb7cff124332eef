"""YAML as plain data."""

from pathlib import Path
from typing import Any

import yaml

from foggy_synscapes.errors import FoggyError

LARGEST = 1_000_000  # bytes; a complete params file has 17,000


class _Loader(yaml.SafeLoader):
    """Plain data only: no tags, no aliases (which can grow without bound), no key twice."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.events.AliasEvent):
            event = self.peek_event()
            raise yaml.constructor.ConstructorError(None, None, "aliases are not allowed in params", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> dict:
        seen = set()
        for place, _ in node.value:
            key = self.construct_object(place, deep=deep)
            if isinstance(key, list | dict):
                raise yaml.constructor.ConstructorError(None, None, "a key must be a word", place.start_mark)
            if key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"key {key!r} stands twice", place.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def read_yaml(path: str | Path) -> Any:
    """Read plain YAML: no tags, no aliases, no key twice. Raises FoggyError naming file and line."""
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise FoggyError(f"{path}: more than {LARGEST:,} bytes; that is no params file")
        return yaml.load(data.decode("utf-8"), Loader=_Loader)
    except FileNotFoundError as error:
        raise FoggyError(f"{path}: no such params file. The default is params.yaml; others are in params/.") from error
    except RecursionError as error:
        raise FoggyError(f"{path}: not a readable params file: nested too deeply") from error
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise FoggyError(f"{path}: not a readable params file: {error}") from error
