"""Equal to the official scorer to the last digit, and to torchmetrics."""

import math

import numpy as np
import pytest

from foggy_synscapes.io.images import encode_png
from foggy_synscapes.labels import CLASSES, from_train_ids
from foggy_synscapes.scoring import iou
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.scoring.tally import Tally

CASES = 300


def random_set(seed):
    """One to three pairs of small labelId maps: few or many ids, with and without void, blocky or noisy."""
    rng = np.random.default_rng(seed)
    labels, predictions = (rng.choice(34, size=rng.integers(1, 34), replace=False) for _ in range(2))
    if seed % 3 == 0:  # as networks predict: evaluated ids only, most of them right
        predictions = np.array([7, 8, 11, 12, 13, 17, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 31, 32, 33])
    block = rng.integers(1, 6)
    for _ in range(rng.integers(1, 4)):
        height, width = rng.integers(1, 24, size=2)
        truth, guess = (
            np.kron(rng.choice(ids, size=(height, width)), np.ones((block, block))).astype(np.uint8)
            for ids in (labels, predictions)
        )
        right = rng.random(truth.shape) < rng.choice([0.0, 0.6])
        yield truth, np.where(right, truth, guess).astype(np.uint8)


@pytest.fixture(scope="module")
def official():
    from cityscapesscripts.evaluation import evalPixelLevelSemanticLabeling as scorer

    # Instance scores need numpy < 2.4 and more files; they are no part of these tables.
    scorer.args.evalInstLevelScore = scorer.args.JSONOutput = False
    scorer.args.quiet = True
    return lambda predictions, labels: scorer.evaluateImgLists(predictions, labels, scorer.args)


def official_scores(official, folder, pairs):
    names = []
    for number, maps in enumerate(pairs):
        names.append([str(folder / f"{side}_{number}.png") for side in ("truth", "guess")])
        for name, ids in zip(names[-1], maps, strict=True):
            with open(name, "wb") as file:
                file.write(encode_png(ids))
    return official([guess for _, guess in names], [truth for truth, _ in names])


def test_equal_to_cityscapesscripts_to_the_last_digit(official, tmp_path):
    absent = falsely_predicted = 0
    for seed in range(CASES):
        pairs = list(random_set(seed))
        expected = official_scores(official, tmp_path, pairs)
        tally = Tally()
        for truth, guess in pairs:
            tally.add(truth, guess, "", "")
        matrix = tally.matrix("labelIds", "labelIds")
        ours, theirs = iou.iou(matrix), [expected["classScores"][name] for name in CLASSES]
        for number, present in enumerate(iou.annotated(matrix)):
            if present:
                assert ours[number] == theirs[number], (seed, CLASSES[number])
            else:
                absent += 1
                falsely_predicted += theirs[number] == 0.0
                assert math.isnan(ours[number])
                assert math.isnan(theirs[number]) or theirs[number] == 0.0
        assert np.array_equal(iou.iou_as_cityscapes(matrix), theirs, equal_nan=True)
        assert np.array_equal(iou.mean_annotated(theirs), expected["averageScoreClasses"], equal_nan=True)
        if not matrix.any():
            continue
        scores = summarize(matrix, len(pairs))
        assert scores["mean_iou_cityscapes"] == 100 * expected["averageScoreClasses"]
        assert scores["mean_category_iou"] == 100 * expected["averageScoreCategories"]
        for entry in scores["categories"]:
            other = expected["categoryScores"][entry["name"]]
            assert entry["iou"] == (None if math.isnan(other) else 100 * other)
        counts = np.array(expected["confMatrix"])
        rows = [7, 8, 11, 12, 13, 17, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 31, 32, 33]
        assert np.array_equal(counts[np.ix_(rows, rows)], scores["confusion"])
        assert np.array_equal(
            np.delete(counts, rows, axis=1)[rows].sum(axis=1, dtype=np.int64), scores["unlabelled_predictions"]
        )
    assert absent > 1000, "the cases must include absent classes"
    assert falsely_predicted > 100, "and such that are falsely predicted"


def test_equal_to_torchmetrics():
    import torch
    from torchmetrics.classification import MulticlassJaccardIndex

    for seed in range(20):
        rng = np.random.default_rng(seed)
        truth = rng.choice(rng.choice(19, size=rng.integers(2, 19), replace=False), size=(40, 50)).astype(np.uint8)
        guess = np.where(rng.random(truth.shape) < 0.5, truth, rng.integers(0, 19, truth.shape)).astype(np.uint8)
        truth[rng.random(truth.shape) < 0.1] = 255
        metric = MulticlassJaccardIndex(num_classes=19, ignore_index=255, average=None)
        theirs = metric(torch.from_numpy(guess.astype(np.int64)), torch.from_numpy(truth.astype(np.int64))).numpy()
        ours = iou.iou(confusion_matrix(truth, guess, classes=19))
        present = ~np.isnan(ours)
        assert np.abs(ours[present] - theirs[present]).max() < 1e-6
        # It shows 0 for a class that is not there; here that is undefined.
        assert not theirs[~present].any()


def test_train_ids_and_label_ids_of_the_same_maps_score_alike():
    rng = np.random.default_rng(0)
    truth, guess = (rng.integers(0, 19, (30, 40)).astype(np.uint8) for _ in range(2))
    truth[:3] = 255
    matrices = []
    for encode, encoding in ((lambda ids: ids, "trainIds"), (from_train_ids, "labelIds")):
        tally = Tally()
        tally.add(encode(truth), encode(guess), "", "")
        matrices.append(tally.matrix(encoding, encoding))
    assert np.array_equal(*matrices)
