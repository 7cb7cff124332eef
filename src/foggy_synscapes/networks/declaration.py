"""What declares a network: its title, its published size, its layers, and how public weights of it are named.

Nothing here imports PyTorch: declarations are read to list names, too.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.networks.preprocessing import Preprocessing

if TYPE_CHECKING:
    from foggy_synscapes.networks.network import Network


@dataclass(frozen=True)
class Layout:
    """One way in which public weights name their tensors.

    network : the network that it is of, or None for a backbone alone
    marks : names (regular expressions) that all occur in files of this layout; a backbone's do in whole networks too
    backbone : a file's names -> key of `BACKBONES`; raises ValueError
    translate : our name and the config -> the name there
    settings : fields of the config that all files of this layout share
    ignored : names (regular expression) that belong to the layout and have no use here, such as ImageNet's classifier
    """

    name: str
    network: str | None
    marks: tuple[str, ...]
    backbone: Callable[[Iterable[str]], str]
    translate: Callable[[str, NetworkConfig], str]
    preprocessing: Preprocessing = field(default_factory=Preprocessing)
    settings: Mapping[str, Any] = field(default_factory=dict)
    ignored: str = r"$^"

    def fits(self, names: Iterable[str]) -> bool:
        """Whether a file with these names is of this layout."""
        names = list(names)
        return all(any(re.fullmatch(mark, name) for name in names) for mark in self.marks)


def by_rules(rules: Sequence[tuple[str, str]]) -> Callable[[str, NetworkConfig], str]:
    """A `translate` by the first of several (regular expression of our name, replacement) that matches."""

    def translate(name: str, _config: NetworkConfig) -> str:
        for pattern, replacement in rules:
            found = re.fullmatch(pattern, name)
            if found:
                return found.expand(replacement)
        raise ValueError(f"{name}: has no counterpart in this layout")

    return translate


def _anything(_config: NetworkConfig) -> None:
    """The check of a network that can have every config."""


@dataclass(frozen=True)
class NetworkEntry:
    """A network of the registry. Its module is named like it and assigns it to `NETWORK`; its layers are in another.

    title : as printed; order : place in lists, from 0, where the paper's tables have it
    backbone, width, decoder : the published size, see `NetworkConfig`
    build : config -> module with random weights; imports the layers, and with them PyTorch
    head : our name of a parameter of the heads used in training alone; None for a network without such
    sizes : fields of the config that a file's tensors tell: for each, our name of a tensor, and its axis
    layouts : the ways in which public weights of it are named
    check : raises ValueError, naming the field, for a config that this network cannot have
    """

    name: str
    title: str
    order: int
    backbone: str
    width: int
    decoder: int
    build: Callable[[NetworkConfig], "Network"]
    head: str | None = None
    sizes: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    layouts: tuple[Layout, ...] = ()
    check: Callable[[NetworkConfig], None] = _anything

    @property
    def published(self) -> NetworkConfig:
        """The config of the published size, with the heads that training uses."""
        return NetworkConfig(self.name, self.backbone, self.width, self.decoder, auxiliary=self.head is not None)
