"""A finished run of the two networks on the stand-in of Foggy Zurich, whose predictions are made up."""

import json
from pathlib import Path

import numpy as np
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import write_shard
from foggy_synscapes.labels import CLASSES, IGNORE, to_train_ids
from foggy_synscapes.params import load
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.metrics import summarize

ROOT = Path(__file__).resolve().parents[2]
TEST_SET, NETWORKS, ROWS = "foggy_zurich", ("refinenet", "bisenet"), ("C", "FS-498")


def finished_run(images: int = 3) -> dict[str, np.ndarray]:
    """Make its files below the current folder; params that show so many images. Truth of each test image by its name.

    A prediction is the ground truth, in which each row has other stripes of one class.
    """
    document = read_yaml(ROOT / "params/smoke.yaml") | {"view": {"images": images}}
    write_text(Path("params.yaml"), json.dumps(document))
    assert main(["scenes", "--dataset", TEST_SET]) == 0
    params, root = load("params.yaml"), Path(f"results/scenes/{TEST_SET}")
    index = read_index(Path(f"results/scenes/index/{TEST_SET}/all.csv"))
    pairs = DATASETS[TEST_SET].tested(root, index, params.scenes)
    truth = {image: to_train_ids(read_ids(root / label), label) for image, label in pairs}
    made = []
    for number, (network, row) in enumerate((network, row) for network in NETWORKS for row in ROWS):
        predicted = {name: striped(found, number) for name, found in truth.items()}
        matrix = sum(confusion_matrix(truth[name], predicted[name], len(CLASSES), IGNORE) for name in truth)
        folder = Path(f"results/evaluate/{TEST_SET}/{network}/{row}/seed-0")
        write_shard(folder / "predictions.tar", ((name, encode_png(predicted[name])) for name in sorted(predicted)))
        write_text(folder / "metrics.json", json.dumps(summarize(np.asarray(matrix), len(truth))))
        made += [folder / "predictions.tar", folder / "metrics.json"]
    vouch(*made)
    return truth


def striped(truth: np.ndarray, number: int) -> np.ndarray:
    """What row `number` predicts: in some columns road for car and car for road, and road where there is no label."""
    road, car = CLASSES.index("road"), CLASSES.index("car")
    found = np.where(truth == IGNORE, road, truth).astype(np.uint8)
    stripe = np.zeros(found.shape, bool)
    stripe[:, number :: 2 + number] = True
    return np.where(stripe & (found == road), car, np.where(stripe & (found == car), road, found)).astype(np.uint8)
