"""What a stand-in declares: which frames it has, and the content of their files."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

Files = list[tuple[str, bytes]]
"""Paths below the root and what is to stand there."""


@dataclass(frozen=True)
class Frame:
    """A frame. Its files are known without rendering it, so that what is there already can be left alone.

    paths : its files below the root
    render : a function of a module that makes their contents from `key`, in this order, as `drawing.encode` takes them
    """

    paths: Sequence[str]
    render: Callable[..., Sequence[Any]]
    key: tuple[Any, ...]


@dataclass(frozen=True)
class StandIn:
    """The stand-in of a dataset. Its functions are given the params section `scenes.stand_in`, called the plan.

    counts : type of its own entry there, how many frames are rendered
    text, published : what they are, and how many the real dataset has, for people
    frames : plan -> frames; ValueError where there cannot be as many
    lists : (frames, params section `scenes`) -> list files
    others : stand-ins whose entries it is rendered by too
    check : raises ValueError where the plan contradicts itself
    tests : params section `scenes` -> number of its frames that networks are tested on
    """

    counts: Any
    text: str
    published: str
    frames: Callable[[Any], list[Frame]]
    lists: Callable[[list[Frame], Any], Files] = field(default=lambda _frames, _scenes: [])
    others: tuple[str, ...] = ()
    check: Callable[[Any], None] = field(default=lambda _plan: None)
    tests: Callable[[Any], int] = field(default=lambda _scenes: 0)


def lines(path: str, texts: Iterable[str]) -> tuple[str, bytes]:
    """A list file."""
    return path, "".join(f"{text}\n" for text in texts).encode()
