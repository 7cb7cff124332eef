"""Reading the metrics files of runs."""

import json
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.scoring.metrics import check


def read_scores(path: Path) -> dict[str, Any] | None:
    """Metrics of a run, as `scoring.metrics.summarize` makes them, or None where the run was not made.

    Raises
    ------
    FoggyError
        If the file is damaged, or holds the scores of other classes.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise FoggyError(f"{path}: cannot be read: {error}") from error
    try:
        document = json.loads(text)
        check(document)
    except ValueError as error:
        raise FoggyError(f"{path}: {error}. Was it made by `foggy evaluate`? Run that again.") from error
    return document
