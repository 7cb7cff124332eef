"""What a stand-in declares: which frames it has, and the content of their files."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

Files = list[tuple[str, Any]]
"""Paths below the root and what is to stand there, as `drawing.encode` takes it."""


class Frame(Protocol):
    """A frame. It knows its files without being rendered, so that what is there already can be left alone."""

    def paths(self) -> list[str]:
        """Files of the frame below the root."""

    def files(self) -> Files:
        """Render the frame."""


def no_lists(_frames: Sequence[Any], _scenes: Any) -> Files:
    """For a dataset without list files."""
    return []


def any_counts(_plan: Any) -> None:
    """For a stand-in that may have as many frames as one likes."""


@dataclass(frozen=True)
class StandIn:
    """The stand-in of a dataset. Its functions are given the params section `scenes.stand_in`, called the plan.

    counts : type of its own entry there, how many frames are rendered
    text, published : what they are, and how many the real dataset has, for people
    frames : plan -> frames; ValueError where there cannot be as many
    lists : (frames, params section `scenes`) -> list files
    others : stand-ins whose entries it is rendered by too
    check : raises ValueError where the plan contradicts itself
    """

    counts: Any
    text: str
    published: str
    frames: Callable[[Any], Sequence[Frame]]
    lists: Callable[[Sequence[Any], Any], Files] = no_lists
    others: tuple[str, ...] = ()
    check: Callable[[Any], None] = any_counts


def lines(path: str, texts: Iterable[str]) -> tuple[str, bytes]:
    """A list file."""
    return path, "".join(f"{text}\n" for text in texts).encode()
