"""Runs a function in several processes that share a training, as torchrun would start them."""

import multiprocessing
import os

from torch.distributed import TCPStore

from foggy_synscapes.training.ranks import joined


def run(count, function, *arguments):
    """What the function returns in each process, by rank; it is called with the process's `Ranks` first."""
    return started(count, _joined, function, *arguments)


def started(count, function, *arguments):
    """What the function returns, or raises, in each process, by rank; each knows of the others by its environment."""
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    # As with torchrun, the store outlives the processes that meet in it.
    store = TCPStore("127.0.0.1", 0, is_master=True, wait_for_workers=False)
    workers = [
        context.Process(target=_one, args=(rank, count, store.port, queue, function, arguments))
        for rank in range(count)
    ]
    for worker in workers:
        worker.start()
    try:
        found = dict(queue.get(timeout=120) for _ in workers)
    finally:
        for worker in workers:
            worker.join(timeout=10)
            worker.kill()
    return [found[rank] for rank in range(count)]


def _joined(function, *arguments):
    with joined() as ranks:
        return function(ranks, *arguments)


def _one(rank, count, port, queue, function, arguments):
    os.environ |= {
        "RANK": str(rank),
        "LOCAL_RANK": str(rank),
        "WORLD_SIZE": str(count),
        "MASTER_ADDR": "127.0.0.1",
        "MASTER_PORT": str(port),
        "TORCHELASTIC_USE_AGENT_STORE": "True",
    }
    try:
        found = function(*arguments)
    except BaseException as error:
        found = error
    queue.put((rank, found))
