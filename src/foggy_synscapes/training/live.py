"""Curves for people to watch while a training runs, by DVCLive or TensorBoard.

They are no results: they are beside the logs, and nothing is made from them.
"""

import importlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError

Values = Mapping[str, float | int | None]


class Live:
    """Passes the values of steps on to the named tools; each begins anew in LOGS/TOOL/NAME.

    Raises FoggyError if a tool is not installed or cannot begin.
    """

    def __init__(self, tools: Sequence[str], logs: Path, name: str) -> None:
        self._writers: list[tuple[Callable[[int, Values], None], Callable[[], None]]] = []
        for tool in tools:
            folder = logs / tool / name
            shutil.rmtree(folder, ignore_errors=True)
            try:
                self._writers.append(STARTS[tool](folder))
            except ImportError as error:
                raise FoggyError(
                    f"train.live: {tool} is not installed ({error}). `pip install .[{tool}]`, or take it off the list."
                ) from error
            except Exception as error:
                raise FoggyError(f"train.live: {tool} cannot begin in {folder}: {error}") from error

    def write(self, step: int, values: Values) -> None:
        """Add the values of a step by their names, such as train/loss; None was not taken."""
        for write, _ in self._writers:
            write(step, {name: value for name, value in values.items() if value is not None})

    def close(self) -> None:
        """Finish the files."""
        for _, close in self._writers:
            close()


def _dvclive(folder: Path) -> tuple[Callable[[int, Values], None], Callable[[], None]]:
    # Not by an import statement, nor is the other: what only watches is no part of what made a result.
    tool = importlib.import_module("dvclive")
    live: Any = tool.Live(str(folder), save_dvc_exp=False, dvcyaml=None, report=None, monitor_system=False)

    def write(step: int, values: Values) -> None:
        live.step = step
        for name, value in values.items():
            live.log_metric(name, value)
        live.make_summary()

    return write, live.end


def _tensorboard(folder: Path) -> tuple[Callable[[int, Values], None], Callable[[], None]]:
    writer: Any = importlib.import_module("torch.utils.tensorboard").SummaryWriter(str(folder))

    def write(step: int, values: Values) -> None:
        for name, value in values.items():
            writer.add_scalar(name, value, step)
        writer.flush()

    return write, writer.close


STARTS = {"dvclive": _dvclive, "tensorboard": _tensorboard}
