"""evaluate: score a model on a test set, or anyone's PNG predictions against ground truth."""

import argparse
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from foggy_synscapes.datasets import DATASETS, test_sets
from foggy_synscapes.datasets.index import expect, read_index
from foggy_synscapes.datasets.scores import by_class, in_words, of_folders, of_test_set, summary
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.ahead import Watch, ahead
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import encode_png, read_ids, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import write_shard
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.scoring.encoding import ENCODINGS
from foggy_synscapes.scoring.tally import Tally

if TYPE_CHECKING:
    from foggy_synscapes.params import Params

HELP = "Score a model on a test set, or any PNG predictions against label maps (IoU in percent)."
JOB = ("network", "row", "seed", "test_set")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    alone = parser.add_argument_group("any predictions", "score PNG files; no params file and no network is needed")
    alone.add_argument("--predictions", type=Path, metavar="DIR", help="folder of predicted ids, 8-bit grey PNG")
    alone.add_argument(
        "--labels",
        type=Path,
        metavar="DIR",
        help="folder of ground truth ids, 8-bit grey PNG; with --test-set: the folder that its archive unpacks to "
        "(default: the root in the params)",
    )
    alone.add_argument("--encoding", choices=ENCODINGS, help="of both, where the ids do not tell it themselves")
    alone.add_argument("--predictions-encoding", choices=ENCODINGS, help="of the predictions alone")
    alone.add_argument("--labels-encoding", choices=ENCODINGS, help="of the label maps alone")
    alone.add_argument("--out", type=Path, metavar="FILE", help="where to write the scores too, e.g. metrics.json")
    alone.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="processes (default: 1); the scores do not change"
    )
    job = parser.add_argument_group("a trained model", "one job of the pipeline, as params.yaml describes it")
    job.add_argument("--network", help="e.g. bisenet")
    job.add_argument("--row", help="row of the tables, e.g. FS-498")
    job.add_argument("--seed", help="e.g. 0")
    job.add_argument("--test-set", help="e.g. foggy_driving; with --predictions: the test set that they are of")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.predictions is None:
        _run_job(args)
        return
    named = [f"--{name}" for name in JOB[:3] if getattr(args, name) is not None]
    if named:
        raise UsageError(f"{named[0]}: names a trained model, which is scored without --predictions")
    if args.labels is None and args.test_set is None:
        raise UsageError("give --labels, the folder of ground truth, or --test-set beside --predictions")
    if args.jobs < 1:
        raise UsageError(f"--jobs {args.jobs}: expected 1 or more")
    guess, truth = args.predictions_encoding or args.encoding, args.labels_encoding or args.encoding
    if args.test_set is None:
        score(args.predictions, args.labels, args.out, guess, truth, jobs=args.jobs)
        return
    if truth not in (None, "labelIds"):
        raise UsageError(f"--test-set {args.test_set}: its label maps are labelIds. Use --predictions-encoding {truth}")
    folder, scenes = _test_set(args)
    found = of_test_set(args.test_set, folder, args.predictions, scenes, guess, args.jobs)
    _told(found, args.out, str(args.predictions))


def _run_job(args: argparse.Namespace) -> None:
    given = {f"--{name.replace('_', '-')}": getattr(args, name) for name in JOB}
    from foggy_synscapes.params import load

    if args.labels or None in given.values():
        raise UsageError(f"give --predictions with --labels or --test-set, or for a trained model {', '.join(given)}")
    params = load(args.params)  # first: it names the folder of plugins, which may have test sets
    _check_name(args.test_set)
    evaluate(params, *given.values())


def _test_set(args: argparse.Namespace) -> tuple[Path, Any]:
    """Folder of the test set that the command line names, and the params section that holds its settings.

    Params are read only where they are needed: for the folder, a plugin or a setting.
    """
    own = args.labels is not None and args.test_set in test_sets() and not DATASETS[args.test_set].settings
    if own:
        return args.labels, None
    there = args.params.is_file()
    if not there:
        _check_name(args.test_set)
        if args.labels is None:
            raise UsageError(f"--test-set {args.test_set}: give --labels, the folder that its archive unpacks to")
    from foggy_synscapes.params import check, load
    from foggy_synscapes.results import root

    params = load(args.params) if there else check({}, "the packaged defaults")
    _check_name(args.test_set)
    return args.labels or root(params, args.test_set), params.scenes


def _check_name(test_set: str) -> None:
    if test_set not in (known := test_sets()):
        raise UsageError(f"--test-set {test_set}: there are {', '.join(known)}")


def _told(found: dict[str, Any], out: Path | None, name: str) -> dict[str, Any]:
    """Write the scores where asked, and print them: how they were read, both means, IoU by class."""
    if out is not None:
        write_text(out, _text(found))
    read = found["encoding"]
    print(f"{out or name}: labels read as {read['labels']}, predictions as {read['predictions']}; {in_words(found)}")
    print(f"IoU in percent, -- where no pixel is annotated:\n{by_class(found)}")
    return found


def score(
    predictions: Path,
    labels: Path,
    out: Path | None = None,
    predictions_encoding: str | None = None,
    labels_encoding: str | None = None,
    jobs: int = 1,
) -> dict[str, Any]:
    """Score a folder of predictions; print the scores, write them to `out` if it is given, and return them.

    Raises
    ------
    FoggyError
        If a file stays without its counterpart, is no 8-bit grey PNG, or differs in size from it; if the encoding
        is open or contradicted; if no pixel is labelled with a class.
    """
    encodings = predictions_encoding, labels_encoding
    return _told(of_folders(predictions, labels, *encodings, jobs, print), out, str(predictions))


def evaluate(params: "Params", network: str, row: str, seed: str, test_set: str) -> None:
    """Predict a test set by a trained model; write `metrics.json`, `predictions.tar` (trainIds) and `run.json`.

    Raises
    ------
    FoggyError
        If the model or an image is missing, damaged or not as listed, or the label maps are not labelIds.
    """
    # Only this way of scoring needs a network and params; loading torch takes seconds, and not all have installed it.
    from foggy_synscapes.networks.device import take
    from foggy_synscapes.networks.weights import load_model
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    asked = params.evaluate
    try:
        device = take(params.device_of("evaluate"), asked.threads, **params.gpu.model_dump())
    except ValueError as error:
        raise FoggyError(str(error)) from error
    this = job(params, "evaluate", network=network, row=row, seed=seed, test_set=test_set)
    source = this.input("model")
    if not source.is_file():
        raise FoggyError(
            f"{source}: missing. Train it first: foggy train --network {network} --row {row} --seed {seed}"
        )
    run = Run(this)
    try:
        model = load_model(read_bytes(source, "model", limit=LARGEST_WEIGHTS))
    except ValueError as error:
        raise FoggyError(f"{source}: {error}") from error
    if model.config.classes != len(CLASSES):
        raise FoggyError(
            f"{source}: predicts {model.config.classes} classes, expected the {len(CLASSES)} of Cityscapes"
        )
    model.network.to(device)
    index, data = read_index(this.input("index")), root(params, test_set)
    pairs = DATASETS[test_set].tested(data, index, params.scenes)
    expect(index, [path for pair in pairs for path in pair], test_set)
    scores: dict[str, Any] = {}
    watch = Watch(ahead(lambda pair: _read(data, index, pair), pairs, asked.workers))
    images = _predictions(model, data, watch, scores)
    write_shard(this.output("predictions"), progress(images, f"evaluate {test_set}", total=len(pairs)))
    run.write(metrics=_text(scores))
    run.finish(device=device)
    waited = f"waited for images {watch.share:.1%} of the time"
    print(f"evaluate {network} {row} seed {seed} on {test_set}: {in_words(scores)}; {waited}")


Pair = tuple[np.ndarray, np.ndarray, str, str]  # image, label map, and their names


def _read(folder: Path, index: dict[str, str], pair: tuple[str, str]) -> Pair:
    image, label = pair
    rgb = read_rgb(read_checked(folder / image, index[image]), str(folder / image))
    return rgb, read_ids(read_checked(folder / label, index[label]), str(folder / label)), image, label


def _predictions(
    model: Any, folder: Path, pairs: Iterable[Pair], scores: dict[str, Any]
) -> Iterator[tuple[str, bytes]]:
    """Predict image by image and give (member name, PNG of trainIds); at the end, put the scores into `scores`.

    Scoring belongs to the iteration so that predictions that cannot be scored are not kept either.
    """
    tally = Tally()
    for rgb, truth, image, label in pairs:
        try:
            predicted = model.predict(rgb)
        except RuntimeError as error:
            # By its name: this module is imported without PyTorch, too.
            if type(error).__name__ != "OutOfMemoryError":
                raise
            size = f"{rgb.shape[0]} x {rgb.shape[1]}"
            raise FoggyError(
                f"{image}: not enough memory on the GPU for {size} pixels. Set evaluate.device to cpu."
            ) from error
        try:
            tally.add(truth, predicted, label, image)
        except ValueError as error:
            raise FoggyError(f"{folder / label}: {error}") from error
        yield image, encode_png(predicted)
    # What the label maps hold is found out, not assumed: trainIds scored as labelIds would pass for a bad network.
    found = summary(tally, None, "trainIds", str(folder))
    if found["encoding"]["labels"] != "labelIds":
        raise FoggyError(f"{folder}: its label maps hold {found['encoding']['labels']} where labelIds are expected")
    scores.update(found)


def _text(scores: dict[str, Any]) -> str:
    return json.dumps(scores, indent=1) + "\n"
