"""YAML as plain data."""

from pathlib import Path
from typing import Any

import yaml

from foggy_synscapes.errors import FoggyError


class _Loader(yaml.SafeLoader):
    """Plain data only: no tags, no aliases (which can grow without bound), no key twice."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.events.AliasEvent):
            event = self.peek_event()
            raise yaml.constructor.ConstructorError(None, None, "aliases are not allowed in params", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> dict:
        keys = [self.construct_object(key, deep=deep) for key, _ in node.value]
        for key, (place, _) in zip(keys, node.value, strict=True):
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(None, None, f"key {key!r} stands twice", place.start_mark)
        return super().construct_mapping(node, deep)


def read_yaml(path: str | Path) -> Any:
    """Read plain YAML: no tags, no aliases, no key twice. Raises FoggyError naming file and line."""
    try:
        with open(path, encoding="utf-8") as file:
            return yaml.load(file, Loader=_Loader)
    except FileNotFoundError as error:
        raise FoggyError(f"{path}: no such params file. The default is params.yaml; others are in params/.") from error
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise FoggyError(f"{path}: not a readable params file: {error}") from error
