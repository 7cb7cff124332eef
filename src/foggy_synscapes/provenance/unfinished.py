"""What an interrupted run of a job finished, kept until the same job goes on."""

import json
import shutil
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import read_bytes
from foggy_synscapes.provenance.runs import Run


def folder_of(run: Run) -> Path:
    """Folder of the members of its shard that an interrupted run of this very job finished, beside the shard.

    It is emptied where any input has changed.
    """
    shard = run.job.output("shard")
    folder = shard.parent / f".{shard.stem}"
    note, text = folder / "job.json", json.dumps(run.identity(), indent=1)
    if not note.is_file() or read_bytes(note) != text.encode():
        if folder.is_dir():
            shutil.rmtree(folder)
        write_text(note, text)
    return folder
