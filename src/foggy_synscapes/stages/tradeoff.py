"""tradeoff: what cheaper arithmetic saves and what it changes, for fog and for trained networks."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.calibration import DATASETS, calibration_images
from foggy_synscapes.datasets.index import expect, index_path, read_index
from foggy_synscapes.datasets.pairs import PairDataset
from foggy_synscapes.datasets.scores import read_scores, scores_path
from foggy_synscapes.datasets.test_sets import labelled_pairs
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames.recipes import composite
from foggy_synscapes.frames.shards import KEPT, read_frame
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import read_ids, read_rgb
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, load, root
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run
from foggy_synscapes.tradeoff import fog

if TYPE_CHECKING:
    from foggy_synscapes.networks.weights import Model
    from foggy_synscapes.tradeoff.networks import Sample, Score
    from foggy_synscapes.tradeoff.training import Cost

HELP = "Measure ways of computing fog and networks: CPU time against what changes. Its times differ run by run."
FOLDER = Path("results/tradeoff")
PARTS = ("fog", "networks")
MODEL = "results/train/{network}/{row}/seed-{seed}/model.safetensors"
LIST = "results/subset/{row}/train.csv"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--part", choices=PARTS, help="what is measured: fog, or trained networks (default: both)")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    params = load(args.params)
    for part in PARTS:
        if args.part in (None, part):
            tradeoff(params, part)


def tradeoff(params: Params, part: str) -> None:
    """Write a part's table, plot and text to results/tradeoff.

    Raises FoggyError if a frame, model, test image or list is missing, damaged or not as recorded.
    """
    {"fog": _fog, "networks": _networks}[part](params)


def _fog(params: Params) -> None:
    from foggy_synscapes.figures.pareto import pareto
    from foggy_synscapes.figures.style import render
    from foggy_synscapes.tables.long import long_table

    inputs: dict[str, str] = {}
    frames = _frames(params, inputs)
    betas = params.tradeoff.betas
    scores = fog.measure(frames, [float(beta) for beta in betas], params.tradeoff.repeats)
    front = fog.pareto_front(scores)
    outputs = [FOLDER / f"fog.{ending}" for ending in ("csv", "tex", "md", "png", "pdf")]
    rows = [fog.row(score, score.variant.name in front) for score in scores]
    write_csv(outputs[0], fog.COLUMNS, rows)
    height, width = frames[0][1].shape
    what = f"{len(betas)} betas, {len(frames)} images of {width} x {height} pixels"
    caption = f"Fog arithmetic: CPU time per image ({what}) and change against float64, in levels of 8 bits."
    write_text(outputs[1], long_table(fog.COLUMNS, rows, caption, "table:tradeoff-fog"))
    write_text(outputs[2], fog.paragraph(scores, what) + "\n")
    points = [(score.variant.name, score.cpu_ms, score.mean) for score in scores if score.cpu_ms is not None]
    figure = pareto(points, front, f"CPU ms per image, {len(betas)} betas", "mean change (levels)")
    for path in outputs[3:]:
        write_bytes(path, render(figure, path.suffix[1:]))
    keys = ("tradeoff.betas", "tradeoff.frames", "tradeoff.repeats", "scenes.roots.synscapes", "scenes.shards")
    _record(params, "fog", keys, inputs, outputs)
    print(f"tradeoff fog: {len(scores)} variants; {outputs[2]}")


def _networks(params: Params) -> None:
    from foggy_synscapes.figures.front import front
    from foggy_synscapes.figures.style import render
    from foggy_synscapes.tables.long import long_table, pipe_table
    from foggy_synscapes.tradeoff import networks, training
    from foggy_synscapes.tradeoff import text as words

    settings, seed = params.tradeoff, params.train.seeds[0]
    models = {name: Path(MODEL.format(network=name, row=settings.row, seed=seed)) for name in params.train.networks}
    lists = [Path(LIST.format(row=row)) for row in dict.fromkeys([settings.row, *params.subset.pure])]
    inputs = checked_inputs([*models.values(), *lists, index_path(f"{settings.test_set}/all")])
    reader = Reader({name: root(params, name) for name in DATASETS})
    calibration = calibration_images(lists[0], reader, settings.calibration, composite)
    samples = _samples(params)
    scores: list[Score] = []
    for name, path in models.items():
        scores += networks.measure(name, _model(path), samples, calibration, settings.scales)
    costs = _costs(params, models, reader, inputs)

    best = networks.pareto_front(scores)
    outputs = [FOLDER / f"networks.{ending}" for ending in ("csv", "tex", "md", "png", "pdf")]
    outputs += [FOLDER / "training.csv", FOLDER / "training.tex"]
    write_csv(outputs[0], words.COLUMNS + words.CLASS_COLUMNS, words.rows(scores, best, classes=True))
    height, width = samples[0][0].shape[:2]
    data = "stand-in " if params.stand_in else ""
    test_set = words.title(settings.test_set)
    what = f"{len(samples)} {data}images of {test_set}, the first of {width} x {height} pixels"
    caption = (
        f"Ways of computing the networks of row {settings.row} (seed {seed}) on {what}: median CPU time of one thread "
        "per image; mean IoU over the annotated classes; changes from PyTorch in float32 at full scale: points of mean "
        "IoU, the class whose IoU changes most, the largest difference of logits, pixels of another class."
    )
    rows = words.printed(words.rows(scores, best))
    write_text(outputs[1], long_table(words.HEADS, rows, caption, "table:tradeoff-networks"))
    ended = words.cost_rows(costs)
    duration = training.caption(settings.steps, test_set)
    parts = [caption, pipe_table(words.HEADS, rows), networks.paragraph(scores)]
    parts += [duration, pipe_table(training.HEADS, words.printed(ended)), training.paragraph(costs)]
    write_text(outputs[2], "\n\n".join(parts) + "\n")
    points = [
        (words.title(one.network), one.way, one.scale, one.cpu_ms, one.miou) for one in scores if one.cpu_ms is not None
    ]
    kept = [good for one, good in zip(scores, best, strict=True) if one.cpu_ms is not None]
    figure = front(points, kept, "CPU ms of one thread per image", f"mean IoU (%), {data}{test_set}")
    for path in outputs[3:5]:
        write_bytes(path, render(figure, path.suffix[1:]))
    write_csv(outputs[5], training.COLUMNS, ended)
    write_text(outputs[6], long_table(training.HEADS, words.printed(ended), duration, "table:tradeoff-training"))
    keys = ("row", "test_set", "scales", "calibration", "steps")
    others = ("scenes.roots", "scenes.zurich_list", "subset.pure", "train")
    _record(params, "networks", (*(f"tradeoff.{key}" for key in keys), *others), inputs, outputs)
    print(f"tradeoff networks: {len(scores)} ways, {sum(best)} of them on the front; {outputs[2]}")


def _record(params: Params, part: str, keys: Sequence[str], inputs: dict[str, str], outputs: Sequence[Path]) -> None:
    write_run(
        FOLDER / f"{part}.run.json",
        command=["foggy", "tradeoff", "--part", part],
        params=recorded(params, *keys),
        inputs=inputs,
        outputs=outputs,
    )


def _frames(params: Params, inputs: dict[str, str]) -> list[fog.Frame]:
    names = [f"synscapes/{shard}" for shard in params.scenes.shards]
    inputs.update(checked_inputs([KEPT, *(index_path(name) for name in names)]))
    index, folder = read_index(*names), root(params, "synscapes")
    rows = read_csv(KEPT, ("id",))[: params.tradeoff.frames]
    if len(rows) < params.tradeoff.frames:
        raise FoggyError(f"tradeoff.frames: asks for {params.tradeoff.frames} frames, but the filter kept {len(rows)}")
    clear = [read_frame(folder, int(row["id"]), index) for row in rows]
    return [(one.image, one.depth, synscapes.camera_of(row)) for one, row in zip(clear, rows, strict=True)]


def _samples(params: Params) -> list["Sample"]:
    """Images and labelIds of the test set."""
    name = params.tradeoff.test_set
    index, folder = read_index(f"{name}/all"), root(params, name)
    pairs = labelled_pairs(name, folder, index, params.scenes.zurich_list)
    expect(index, [path for pair in pairs for path in pair], name)
    read = {path: read_checked(folder / path, index[path]) for pair in pairs for path in pair}
    return [
        (read_rgb(read[image], str(folder / image)), read_ids(read[label], str(folder / label)), image)
        for image, label in pairs
    ]


def _model(path: Path) -> "Model":
    from foggy_synscapes.networks.weights import load_model

    try:
        return load_model(path.read_bytes())
    except ValueError as error:
        raise FoggyError(f"{path}: {error}") from error


def _costs(params: Params, models: dict[str, Path], reader: Reader, inputs: dict[str, str]) -> list["Cost"]:
    """What fine-tuning each network on each list of purely synthetic images costs, and what it scores."""
    from foggy_synscapes.tradeoff.training import Cost, seconds_per_step
    from foggy_synscapes.training.forward import Arithmetic
    from foggy_synscapes.training.policy import Policy

    settings, train = params.tradeoff, params.train
    arithmetic = Arithmetic("cpu", train.precision, train.memory_format)
    costs = []
    for name, path in models.items():
        chosen = getattr(train, name).fine_tuning
        policy = Policy(**chosen.model_dump(include=set(Policy.__dataclass_fields__)))
        for row in params.subset.pure:
            samples = PairDataset(Path(LIST.format(row=row)), reader, train.cache * 2**20, composite)
            seconds = seconds_per_step(_model(path), policy, arithmetic, samples, settings.steps)
            scores = scores_path(settings.test_set, name, row, train.seeds[0])
            found = read_scores(scores)
            if found is not None:
                inputs.update(checked_inputs([scores]))
            iterations = train.rows[row].length.steps(samples.count, policy.batch)
            miou = found and found["mean_iou"]["annotated"]
            costs.append(Cost(name, row, samples.count, iterations, seconds, miou))
    return costs
