"""What training, validation and evaluation cost in multiply-adds, and what results take on disk.

Multiply-adds of an image are those of the network as the params shape it, in proportion to its pixels; a step backwards
counts as two forwards. Sizes are those of the real datasets, or of the stand-in where that is drawn.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from math import prod

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.dataset import STAND_IN
from foggy_synscapes.jobs import Job
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.params import Params
from foggy_synscapes.params.experiment import Training
from foggy_synscapes.standin.layouts import STAND_INS
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import COMPLETED, FOG, MODELLED

PASSES = 3
"""Forward passes that a step of training costs: one forward, and backwards two."""
FOGGY = 1.16
"""Bytes of a pixel of a foggy PNG: 1.2 MB for a real frame of 1440 x 720 at png_level 0."""
RECIPE = 500
"""Bytes of a foggy image that is composited when training reads it."""
DRAWN = 4
"""Bytes of a pixel of a drawn frame, all of its files together: 3.9 measured over the stand-in of params.yaml."""
PREDICTED = 0.02
"""Bytes of a pixel of a predicted label map; Cityscapes' own labels, which are smoother, have 0.010 to 0.014."""
MEMBER = 1024
"""Bytes that each file of a tar archive adds."""
FLOAT = 4
"""Bytes of a weight."""


def config(params: Params, network: str) -> NetworkConfig:
    """A network as these params shape it."""
    settings = params.train.network(network)
    sizes = {name: getattr(settings, name) for name in ("backbone", "width", "decoder")}
    return replace(NETWORKS[network].published, classes=len(CLASSES), **sizes)


def per_pixel(params: Params, network: str) -> float:
    """Multiply-adds of a forward pass for each pixel of an image."""
    return _per_pixel(config(params, network))


@cache
def _per_pixel(shape: NetworkConfig) -> float:
    from foggy_synscapes.networks.catalogue import multiply_adds

    size = 512, 1024
    return multiply_adds(shape, size) / prod(size)


@cache
def _parameters(shape: NetworkConfig) -> int:
    from foggy_synscapes.networks.catalogue import parameters

    return parameters(shape)


def is_drawn(params: Params, dataset: str) -> bool:
    """Whether a dataset is the stand-in."""
    return params.scenes.roots.get(dataset) == STAND_IN


def pixels(params: Params, dataset: str) -> int:
    """Pixels of an image of a dataset."""
    return prod(params.scenes.stand_in.size) if is_drawn(params, dataset) else DATASETS[dataset].pixels


def tested(params: Params, dataset: str) -> int:
    """Images of a test set."""
    entry = STAND_INS[dataset] if is_drawn(params, dataset) else DATASETS[dataset]
    return entry.tests(params.scenes)


def steps(params: Params, training: Training) -> float:
    """Multiply-adds of the steps of a training, validations not counted."""
    return PASSES * training.images_seen * prod(training.policy.crop) * per_pixel(params, training.network)


def validations(params: Params, training: Training) -> float:
    """Multiply-adds of all validations of a training."""
    row = training.row
    entry = params.subset.rows()[row]
    own = "synscapes" if {FOG, COMPLETED, MODELLED} & {*KINDS[params.subset.kind(row)].reads} else "cityscapes"
    # What a list holds beyond its entry's own counts are the Foggy Cityscapes images of a mix.
    more = entry.counts()[1] - entry.validation
    whole = pixels(params, own) * entry.validation + (pixels(params, "cityscapes") * more if more else 0)
    return training.validations * whole * per_pixel(params, training.network)


def evaluation(params: Params, network: str, test_set: str) -> float:
    """Multiply-adds of the evaluation of a model on a test set."""
    return tested(params, test_set) * pixels(params, test_set) * per_pixel(params, network)


def fogged(params: Params, shards: int) -> int:
    """Frames of so many shards that fog is made on, at each beta."""
    ends = params.fog.frames
    return min(ends.first + ends.last, shards * params.scenes.shard_frames)


def disk(params: Params, jobs: Iterable[Job]) -> float:
    """Bytes that the results of jobs take in the end: fog, models, predictions and what is drawn.

    Snapshots, three times a model while it trains, and the copies of DVC's cache, where the file system makes copies,
    are not counted, nor is what is small: indexes, lists, scores, tables and figures.
    """
    total = 0.0
    shards: dict[str, list[str]] = {}
    for job in jobs:
        name, values = job.step.name, job.values
        if name == "fog_completed":
            total += (MEMBER + FOGGY * pixels(params, "synscapes")) * fogged(params, 1)
        elif name in ("fog", "fog_model"):
            shards.setdefault(f"{values.get('model', '')} {values['beta']}", []).append(values["shard"])
        elif job.step.word == "train":
            total += FLOAT * _parameters(config(params, values["network"]))
        elif job.step.word == "evaluate":
            images = tested(params, values["test_set"])
            total += images * (MEMBER + PREDICTED * pixels(params, values["test_set"]))
        elif job.step.word == "scenes":
            dataset = name.removeprefix("scenes_")
            if is_drawn(params, dataset):
                frames = len(STAND_INS[dataset].frames(params.scenes.stand_in))
                total += frames * DRAWN * pixels(params, dataset)
    image = RECIPE if params.fog.render == "on_the_fly" else FOGGY * pixels(params, "synscapes")
    return total + (MEMBER + image) * sum(fogged(params, len(each)) for each in shards.values())
