"""What figures are drawn from, read from results and datasets."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import DATASETS, foggy_cityscapes, synscapes
from foggy_synscapes.datasets.dataset import STAND_IN
from foggy_synscapes.datasets.index import expect, read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.frame import foggy_frame
from foggy_synscapes.fog.models import chosen
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import read_depth, read_ids, read_rgb
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.labels import to_train_ids
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.scoring.metrics import read_scores

Points = list[tuple[float, float]]


@dataclass(frozen=True)
class Frame:
    """A kept Synscapes frame: id, clear image uint8 (H, W, 3), planar depth in metres (H, W), camera."""

    number: int
    clear: np.ndarray
    depth: np.ndarray
    camera: Camera

    def foggy(self, betas: list[str], fog: Any) -> list[np.ndarray]:
        """Foggy images, uint8 (H, W, 3), one for each beta in 1/m, by model and geometry of the params section fog."""
        model, wanted = chosen(fog.spelt()), [float(beta) for beta in betas]
        try:
            return foggy_frame(self.clear, self.depth, self.camera, wanted, fog.geometry, model.images)
        except ValueError as error:
            raise FoggyError(f"frame {self.number}: {error}") from error


@dataclass(frozen=True)
class Sample:
    """A test image: its name, rgb uint8 (H, W, 3), truth as trainIds uint8 (H, W)."""

    name: str
    rgb: np.ndarray
    truth: np.ndarray


class Sources:
    """Reads what a figure shows.

    job : whose files are read; runs are shown of the first seed, scores on the test set of a figure that is of one
    roots : folder of each dataset

    Each method raises FoggyError where a file is missing, damaged, or not as listed.
    """

    def __init__(self, job: Any, roots: Mapping[str, Path]) -> None:
        self.job, self.params, self._roots = job, job.params, roots
        self._seed = self.params.train.seeds[0]

        self.test_set = job.values.get("test_set", "")

    @property
    def networks(self) -> dict[str, str]:
        """Networks by name, as people call them."""
        return {name: NETWORKS[name].title for name in self.params.train.networks}

    @property
    def rows(self) -> list[str]:
        """Rows that are trained, in the order of the tables."""
        trained = [*self.params.train.from_weights, *self.params.train.from_baseline]
        printed = [entry.row for entry in self.params.tables.rows]
        return [row for row in dict.fromkeys((*printed, *trained)) if row in trained]

    def title(self) -> str:
        """The test set as people call it."""
        return DATASETS[self.test_set].short_title + (" (stand-in)" if self.params.stand_in else "")

    def drawn(self, dataset: str) -> bool:
        """Whether a dataset is the stand-in."""
        return self.params.scenes.roots[dataset] == STAND_IN

    def frames(self, count: int) -> list[Frame]:
        """The first kept frames of Synscapes."""
        index, folder = read_index(*self.job.inputs("synscapes")), self._roots["synscapes"]
        frames = []
        for row in read_csv(self.job.input("kept"), ("id",))[:count]:
            number = int(row["id"])
            paths = synscapes.rgb(number), synscapes.depth(number)
            expect(index, paths, "synscapes")
            image, depth = (read_checked(folder / path, index[path]) for path in paths)
            camera = synscapes.camera_of(row)
            frames.append(Frame(number, read_rgb(image, paths[0]), read_depth(depth, paths[1]), camera))
        return frames

    def refined(self, beta: str, count: int) -> list[np.ndarray]:
        """The first refined training images of Foggy Cityscapes at a beta in 1/m, uint8 (H, W, 3)."""
        index, folder = read_index(*self.job.inputs("foggy_cityscapes")), self._roots["foggy_cityscapes"]
        listed = foggy_cityscapes.read_refined(folder, self.params.scenes.refined_list, index)["train"][:count]
        paths = [foggy_cityscapes.image(frame, beta) for frame in listed]
        expect(index, paths, "foggy_cityscapes")
        return [read_rgb(read_checked(folder / path, index[path]), path) for path in paths]

    def filter(self, key: str) -> tuple[list[float], list[bool]]:
        """A scene key of each frame, and whether the filter kept the frame."""
        frames = read_csv(self.job.input("filter"), (key, "kept"))
        return [float(frame[key]) for frame in frames], [frame["kept"] == "1" for frame in frames]

    def curves(self, network: str, row: str) -> tuple[Points, Points]:
        """Training and validation losses over the share of a training that is done, in percent."""
        table = read_csv(self._run("curves", network, row), ("step", "train_loss", "validation_loss"))
        last = max((int(line["step"]) for line in table), default=1)

        def points(name: str) -> Points:
            return [(100 * int(line["step"]) / last, float(line[name])) for line in table if line[name]]

        return points("train_loss"), points("validation_loss")

    def scores(self, network: str) -> dict[str, dict[str, Any]]:
        """Scores of a network by row, as `scoring.metrics.summarize` makes them, of the runs that exist."""
        runs = {row: read_scores(self._run("metrics", network, row)) for row in self.rows}
        return {row: run for row, run in runs.items() if run is not None}

    def metrics(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Scores by network and row, as `scoring.metrics.summarize` makes them, of the runs that exist."""
        found: dict[str, dict[str, dict[str, Any]]] = {}
        for network in self.params.train.networks:
            found[network] = self.scores(network)
            if not found[network]:
                raise FoggyError(f"figures: no scores of {network} on {self.test_set}; run `foggy evaluate` first")
        return found

    def _run(self, name: str, network: str, row: str) -> Path:
        return self.job.one(name, network=network, row=row, seed=self._seed)

    def predictions(self, network: str, row: str, names: list[str]) -> list[np.ndarray]:
        """Predicted trainIds, uint8 (H, W), of the test images of these names."""
        path = self._run("predictions", network, row)
        with Shard(path) as shard:
            return [read_ids(shard.read(name), f"{path}#{name}") for name in names]

    def images(self, count: int) -> list[Sample]:
        """So many test images at even distances, the first one included, and their ground truth."""
        index, folder = read_index(self.job.input("images")), self._roots[self.test_set]
        pairs = spread(DATASETS[self.test_set].tested(folder, index, self.params.scenes), count)
        expect(index, [path for pair in pairs for path in pair], self.test_set)
        samples = []
        for image, label in pairs:
            rgb = read_rgb(read_checked(folder / image, index[image]), image)
            ids = read_ids(read_checked(folder / label, index[label]), label)
            try:
                samples.append(Sample(image, rgb, to_train_ids(ids, label)))
            except ValueError as error:
                raise FoggyError(str(error)) from error
        return samples


def spread(items: list, count: int) -> list:
    """`count` items at even distances, the first one included.

    >>> spread(list(range(10)), 4)
    [0, 2, 5, 7]
    """
    count = min(count, len(items))
    return [items[number * len(items) // count] for number in range(count)]
