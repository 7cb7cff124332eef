"""Reading the metrics files of runs."""

import os
from pathlib import Path
from typing import Any

from foggy_synscapes.io.files import named, read_json
from foggy_synscapes.scoring.metrics import check


def read_scores(path: Path) -> dict[str, Any] | None:
    """Metrics of a run, as `scoring.metrics.summarize` makes them, or None where the run was not made.

    Raises
    ------
    FoggyError
        If the file is damaged, or holds the scores of other classes.
    """
    if not os.path.lexists(path):
        return None
    advice = "Was it made by `foggy evaluate`? Run that again."
    document = read_json(path, "file of metrics", advice)
    with named(path, "file of metrics", advice):
        check(document)
    return document
