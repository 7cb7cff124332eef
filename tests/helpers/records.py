"""Run records for results that a test puts there in place of a step."""

import json
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.provenance.runs import record_of
from foggy_synscapes.results import index


def vouch(*paths: str | Path) -> None:
    """Record files as they are now, as their steps would have; without any named, all results that there are."""
    found = [path for path in Path("results").rglob("*") if path.is_file() and ".run." not in path.name]
    for path in map(Path, paths or sorted(found)):
        if path.name == "run.json" or path.name.startswith("."):
            continue
        place = record_of(path)
        record = json.loads(place.read_text()) if place.is_file() else {"command": ["foggy"], "inputs": {}}
        record.setdefault("outputs", {})[path.as_posix()] = sha256(path)
        write_text(place, json.dumps(record))


def index_of(dataset: str, part: str = "all") -> Path:
    """Where the index of a dataset, or of a shard of it, is."""
    return Path(index(dataset, part))
