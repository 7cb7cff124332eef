"""Whatever happened to a folder, the normal command makes what a clean run of the same state makes, and no more."""

import time

import stateful
from hypothesis import settings
from hypothesis.stateful import run_state_machine_as_test

SECONDS = 25


def test_after_any_history_one_command_makes_the_results_of_a_clean_run() -> None:
    end = time.monotonic() + SECONDS
    rounds = 0
    while time.monotonic() < end:
        rounds += 1
        run_state_machine_as_test(stateful.History, settings=settings(stateful.SETTINGS, derandomize=rounds == 1))
    print(stateful.told())
    assert stateful.COUNTS["commands"] > 50
    assert stateful.COUNTS["stale"] == stateful.COUNTS["stuck"] == stateful.COUNTS["needless"] == 0
