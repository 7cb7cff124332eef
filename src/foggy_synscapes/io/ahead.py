"""Items made ahead by threads, in their order, and the share of time that was waited for them."""

import itertools
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Generic, TypeVar

Source = TypeVar("Source")
Item = TypeVar("Item")


def ahead(make: Callable[[Source], Item], sources: Iterable[Source], threads: int) -> Iterator[Item]:
    """What `make` makes of each source, in order; so many threads make two items each ahead, 0 makes them here.

    What `make` raises is raised in the place of its item.
    """
    if threads == 0:
        yield from map(make, sources)
        return
    pool, waiting = ThreadPoolExecutor(threads), deque[Future[Item]]()
    try:
        for source in sources:
            waiting.append(pool.submit(make, source))
            if len(waiting) > 2 * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


class Watch(Generic[Item]):
    """Passes items on, and takes the time that is waited for them but for the first, before which workers start."""

    def __init__(self, items: Iterable[Item]) -> None:
        self._items, self._waited, self._between = items, 0.0, 0.0

    def __iter__(self) -> Iterator[Item]:
        source = iter(self._items)
        yield from itertools.islice(source, 1)
        self._between = 0.0
        while True:
            begin = time.perf_counter()
            found = next(source, None)
            end = time.perf_counter()
            if found is None:
                return
            self._waited += end - begin
            yield found
            self._between += time.perf_counter() - end

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Within it, as in a validation, time does not count."""
        begin = time.perf_counter()
        yield
        self._between -= time.perf_counter() - begin

    @property
    def share(self) -> float:
        """Time waited, as a share of all; 0 where there was one item."""
        whole = self._waited + self._between
        return self._waited / whole if whole > 0 else 0.0
