"""Where results are: folders and files that several steps know, below the folder of the project."""

from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.params import STAND_IN, Params

RESULTS = "results"
SCENES = f"{RESULTS}/scenes"
INDEX = f"{SCENES}/index"
KEPT = f"{RESULTS}/filter/kept.csv"
COMPLETE = f"{RESULTS}/complete"
FOG = f"{RESULTS}/fog"
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"
CODE = f"{RESULTS}/code"
"""Digests of the code of each job, for DVC: see `foggy code`."""
RUN = "{network}/{row}/seed-{seed}"
TRAINED = f"{RESULTS}/train/{RUN}"
SCORED = f"{RESULTS}/evaluate/{{test_set}}/{RUN}"
MODEL = f"{TRAINED}/model.safetensors"
METRICS = f"{SCORED}/metrics.json"
LIST = f"{RESULTS}/subset/{{row}}/train.csv"
TABLE = f"{RESULTS}/tables/{{test_set}}"
PAPERS_TABLE = f"{RESULTS}/tables/paper/{{test_set}}"


def index(dataset: str, part: str = "all") -> str:
    """Where the index of a dataset, or of a shard of it, is."""
    return f"{INDEX}/{dataset}/{part}.csv"


def run_file(template: str, test_set: str = "", network: str = "", row: str = "", seed: str = "") -> Path:
    """A file of one run or list, from MODEL, METRICS, LIST or TABLE."""
    return Path(template.format(test_set=test_set, network=network, row=row, seed=seed))


def root(params: Params, dataset: str) -> Path:
    """Folder in which a dataset's real layout begins."""
    folder = params.scenes.roots.get(dataset)
    if folder is None:
        raise FoggyError(f"scenes.roots.{dataset}: missing. Give the dataset's folder.")
    return Path(SCENES) / dataset if folder == STAND_IN else Path(folder)


def roots(params: Params) -> dict[str, Path]:
    """Folder of each dataset of the params, in which its real layout begins."""
    return {name: root(params, name) for name in params.scenes.roots}
