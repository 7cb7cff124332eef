"""What several steps read and write: templates of files, and wildcards that runs share."""

from collections.abc import Callable, Iterable

from foggy_synscapes import stereo_steps
from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.jobs import Each, Template
from foggy_synscapes.results import FOG, INDEX, KEPT, RESULTS, RUN, index

NETWORK, SEED, FOG_MODEL = "train.networks", "train.seeds", "fog.model"
FOG_VALUES = "fog.values"
ROWS = ("train.from_weights", "train.from_baseline")
RUNS = {"network": (NETWORK,), "row": ROWS, "seed": (SEED,)}


def files(path: str, *endings: str) -> dict[str, Template]:
    return {ending: f"{path}.{ending}" for ending in endings}


def index_of(dataset: str) -> Template:
    """The index of a dataset, all parts of it."""
    key = DATASETS[dataset].parts
    return Each(f"{INDEX}/{dataset}", "{part}.csv", {"part": (key,)}) if key else index(dataset)


def indexes(*datasets: str) -> dict[str, Template]:
    return {dataset: index_of(dataset) for dataset in datasets}


SOURCES: dict[str, Callable[[], dict[str, Template]]] = {
    "frames": lambda: {**indexes("synscapes"), "kept": KEPT},
    "refined": lambda: indexes("cityscapes", "foggy_cityscapes"),
    "filter": lambda: {"filter": f"{RESULTS}/filter/frames.csv"},
    "fog": lambda: {
        "kept": KEPT,
        "fog": Each(f"{FOG}/beta_{{row.beta}}", "{shard}.csv", {"shard": ("scenes.shards",)}),
    },
    "made": stereo_steps.made_images,
    "completed": lambda: {"kept": KEPT, **stereo_steps.completed_images()},
    "modelled": lambda: {
        "kept": KEPT,
        "modelled": Each(f"{FOG}/{{row.model}}/beta_{{row.beta}}", "{shard}.csv", {"shard": ("scenes.shards",)}),
    },
    "curves": lambda: {"curves": Each(f"{RESULTS}/train", f"{RUN}/curves.csv", RUNS)},
    "metrics": lambda: {"metrics": Each(f"{RESULTS}/evaluate/{{test_set}}", f"{RUN}/metrics.json", RUNS)},
    "predictions": lambda: {"predictions": Each(f"{RESULTS}/evaluate/{{test_set}}", f"{RUN}/predictions.tar", RUNS)},
    "images": lambda: {"images": index("{test_set}")},
}
"""What lists and figures may read beside the indexes of datasets, by the names under which they declare it."""


def sources(names: Iterable[str]) -> dict[str, Template]:
    found = [SOURCES[name]() if name in SOURCES else indexes(name) for name in names]
    return {key: template for each in found for key, template in each.items()}
