"""Progress for people: bars on a terminal, and for what takes hours lines in a log."""

import sys
import time
from collections.abc import Iterable, Iterator
from datetime import timedelta
from typing import TypeVar

from tqdm import tqdm

Item = TypeVar("Item")


def progress(items: Iterable[Item], label: str, total: int | None = None, unit: str = "image") -> Iterator[Item]:
    """Pass the items on and show on a terminal how many are done, how fast, and the time left."""
    # disable=None is tqdm's "only on a terminal".
    return iter(tqdm(items, desc=label, total=total, unit=unit, disable=None, smoothing=0.1))


class Progress:
    """How far something long is, how fast, and the time left: a bar on a terminal, else a line now and then.

    label : begins each line; total, unit : how many of what there are; done : how many are there from an earlier run
    every : seconds between two lines, of which each is written through to the file at once
    """

    def __init__(self, label: str, total: int, unit: str = "image", done: int = 0, every: float = 30) -> None:
        self._label, self._total, self._unit, self._every = label, total, unit, every
        self._bar = tqdm(desc=label, total=total, unit=unit, initial=done, disable=None)
        self._first = self._last = time.monotonic()
        self._done = self._began = done

    def update(self, done: int, **values: str) -> None:
        """Say how many are done in all, and what is worth knowing, such as the loss."""
        if not self._bar.disable:
            self._bar.set_postfix(values, refresh=False)
            self._bar.update(done - self._bar.n)
            return
        now = time.monotonic()
        # The first tells that it has begun, the second how fast it is.
        if now - self._last >= self._every or self._done == self._began or done == self._total:
            rate = (done - self._began) / max(now - self._first, 1e-9)
            left = timedelta(seconds=round((self._total - done) / rate)) if rate else "unknown"
            said = "".join(f", {name} {value}" for name, value in values.items())
            told = f"{self._label}: {done:,} of {self._total:,} {self._unit}s{said}"
            print(f"{told}, {rate:.3g} {self._unit}s/s, {left} left", file=sys.stderr, flush=True)
            self._last = now
        self._done = done

    def close(self) -> None:
        """Leave the terminal as it was."""
        self._bar.close()
