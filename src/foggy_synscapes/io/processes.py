"""Work shared by several processes of this machine, which end with the one that started them."""

import ctypes
import signal
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

from foggy_synscapes.errors import FoggyError

PR_SET_PDEATHSIG = 1  # sys/prctl.h
AHEAD = 3  # tasks per process that are handed out before the first is done: keeps all busy, and memory constant

Task = TypeVar("Task")
Result = TypeVar("Result")


def in_processes(
    work: Callable[[Task], Result],
    tasks: Iterable[Task],
    processes: int,
    name: Callable[[Task], str] = str,
    begin: Callable[[], None] | None = None,
) -> Generator[Result, None, None]:
    """What `work` makes of each task, in the order of the tasks; in this process where one is enough.

    name : what to call a task in an error; begin : called once in each process that works

    Raises FoggyError if a process dies, with the names of the tasks that were under way.
    """
    if processes <= 1:
        if begin is not None:
            begin()
        yield from map(work, tasks)
        return
    pool = ProcessPoolExecutor(processes, initializer=_begin, initargs=(begin,))
    waiting: deque[tuple[Task, Future[Result]]] = deque()
    try:
        for task in tasks:
            waiting.append((task, pool.submit(work, task)))
            if len(waiting) > AHEAD * processes:
                yield waiting[0][1].result()
                waiting.popleft()
        while waiting:
            yield waiting[0][1].result()
            waiting.popleft()
    except BrokenProcessPool as error:
        broken = [task for task, future in waiting if isinstance(future.exception(), BrokenProcessPool)]
        raise FoggyError(
            f"a process was killed, perhaps for lack of memory, at {' or '.join(map(name, broken[:processes]))}. Use "
            "fewer --jobs and run the same command to go on."
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _begin(begin: Callable[[], None] | None) -> None:
    """What a process does first."""
    # Ctrl-C reaches all processes: the first one stops the others, which finish their task.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    library = ctypes.CDLL(None)
    if hasattr(library, "prctl"):  # Linux: a killed first process would leave the others waiting for ever
        library.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if begin is not None:
        begin()
