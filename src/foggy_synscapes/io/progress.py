"""Progress bars for people; nothing is printed where standard error is not a terminal."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from tqdm import tqdm

Item = TypeVar("Item")


def progress(items: Iterable[Item], label: str, total: int | None = None, unit: str = "image") -> Iterator[Item]:
    """Pass the items on and show on a terminal how many are done, how fast, and the time left."""
    # disable=None is tqdm's "only on a terminal".
    return iter(tqdm(items, desc=label, total=total, unit=unit, disable=None, smoothing=0.1))
