"""Items that threads make ahead come in order, and waiting for them is counted."""

import threading
import time

import pytest

from foggy_synscapes.io.ahead import Watch, ahead


@pytest.mark.parametrize("threads", [0, 1, 3])
def test_items_come_in_their_order(threads):
    def make(number):
        time.sleep(0.002 * (number % 3))
        return number * number

    assert list(ahead(make, range(20), threads)) == [number * number for number in range(20)]


def test_items_are_made_before_they_are_asked_for():
    made = threading.Semaphore(0)
    items = ahead(lambda number: made.release() or number, range(6), 2)
    assert next(items) == 0
    for _ in range(5):
        assert made.acquire(timeout=5)
    assert list(items) == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("threads", [0, 2])
def test_an_error_comes_in_the_place_of_its_item(threads):
    found = []
    with pytest.raises(ZeroDivisionError):
        found.extend(ahead(lambda number: 1 // (3 - number), range(6), threads))
    items = ahead(lambda number: 1 // (3 - number), range(6), threads)
    assert [next(items) for _ in range(3)] == [0, 0, 1]


def slowly(seconds, count=4):
    for number in range(count):
        time.sleep(seconds)
        yield number


def test_the_share_that_is_waited_is_that_of_the_time_after_the_first_item():
    watch = Watch(slowly(0.02))
    for _ in watch:
        time.sleep(0.02)
    assert watch.share == pytest.approx(0.5, abs=0.2)
    quick = Watch(iter(range(4)))
    for _ in quick:
        time.sleep(0.01)
    assert quick.share < 0.05


def test_a_pause_counts_for_nothing():
    watch = Watch(slowly(0.02))
    for _ in watch:
        with watch.paused():
            time.sleep(0.05)
    assert watch.share > 0.8
