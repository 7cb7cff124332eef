"""tradeoff: what cheaper arithmetic saves and what it changes, for fog and for trained networks."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from foggy_synscapes.datasets import DATASETS, synscapes
from foggy_synscapes.datasets.index import expect, read_index
from foggy_synscapes.datasets.pairs import PairDataset, calibration_images
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames.compositing import composite
from foggy_synscapes.frames.rendering import read_frame
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import read_ids, read_rgb
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import FOG, METRICS, root, roots, run_file
from foggy_synscapes.scoring.metrics import read_scores
from foggy_synscapes.steps import job
from foggy_synscapes.tradeoff import fog

if TYPE_CHECKING:
    from foggy_synscapes.networks.weights import Model
    from foggy_synscapes.tradeoff.networks import Sample
    from foggy_synscapes.tradeoff.training import Cost
    from foggy_synscapes.training.policy import Policy

HELP = "Measure ways of computing fog and networks: CPU time against what changes. Its times differ run by run."
PARTS = ("fog", "networks", "accuracy")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument(
        "--part",
        choices=PARTS,
        help="what is measured: ways of computing fog, trained networks, or their accuracy in fog made in other "
        "ways (default: all)",
    )


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
    {"fog": _fog, "networks": _networks, "accuracy": _accuracy}[part](params)


def _fog(params: Params) -> None:
    from foggy_synscapes.figures.pareto import errors_front
    from foggy_synscapes.figures.style import render
    from foggy_synscapes.tables.formats import long_latex

    run = Run(job(params, "tradeoff_fog"))
    frames = _frames(run.job)
    betas = params.tradeoff.betas
    scores = fog.measure(frames, [float(beta) for beta in betas], params.tradeoff.repeats)
    front = fog.pareto_front(scores)
    table = fog.table(scores, front)
    height, width = frames[0][1].shape
    what = f"{len(betas)} betas, {len(frames)} images of {width} x {height} pixels"
    caption = f"Fog arithmetic: CPU time per image ({what}) and change against float64, in levels of 8 bits."
    points = [(score.variant.name, score.cpu_ms, score.mean) for score in fog.timed(scores)]
    figure = errors_front(points, front, f"CPU ms per image, {len(betas)} betas", "mean change (levels)")
    run.write(
        csv=table.to_csv(index=False, lineterminator="\n"),
        tex=long_latex(table, caption, "table:tradeoff-fog"),
        md=fog.paragraph(scores, what) + "\n",
        **{ending: render(figure, ending) for ending in ("png", "pdf")},
    )
    run.finish()
    print(f"tradeoff fog: {len(scores)} variants; {run.job.output('md')}")


def _networks(params: Params) -> None:
    from foggy_synscapes.figures.pareto import accuracy_front
    from foggy_synscapes.figures.style import render
    from foggy_synscapes.networks import titles
    from foggy_synscapes.tables.formats import long_latex, long_markdown
    from foggy_synscapes.tradeoff import networks, training

    settings, seed = params.tradeoff, params.train.seeds[0]
    this = job(params, "tradeoff_networks")
    # Of runs that were not scored there is no score.
    scored = set(this.inputs("metrics"))
    run = Run(this, [path for path in this.read() if path not in scored or path.is_file()])
    models = dict(zip(params.train.networks, this.inputs("models"), strict=True))
    lists = dict(zip([settings.row, *params.subset.kinds()["pure"]], this.inputs("lists"), strict=True))
    reader = Reader(roots(params), FOG)
    calibration = calibration_images(lists[settings.row], reader, settings.calibration, composite)
    loaded = {name: _model(path) for name, path in models.items()}
    samples, known = _samples(this, loaded)
    scores = [
        score
        for name, model in loaded.items()
        for score in networks.measure(name, model, samples, calibration, settings.scales)
    ]
    costs = _costs(this, models, lists, reader)

    best = networks.pareto_front(scores)
    measured, ended = networks.table(scores, best), training.table(costs)
    height, width = samples[0][0].shape[:2]
    data = "stand-in " if params.stand_in else ""
    test_set = DATASETS[settings.test_set].title
    what = f"{len(samples)} of {known} {data}images of {test_set}, the first of {width} x {height} pixels"
    caption = (
        f"Ways of computing the networks of row {settings.row} (seed {seed}) on {what}: median CPU time of one thread "
        "per image; mean IoU over the annotated classes; changes from PyTorch in float32 at full scale: points of mean "
        "IoU with their 95 % interval (paired bootstrap over the images), the class whose IoU changes most, largest "
        "difference of logits, pixels of another class."
    )
    ways, prices = networks.printed(measured, networks.BACKENDS), networks.printed(ended, training.COSTS)
    duration = training.caption(settings.steps, test_set)
    parts = [caption, long_markdown(ways), networks.paragraph(scores, settings.tolerance)]
    parts += [duration, long_markdown(prices), training.paragraph(costs)]
    points = [(titles()[one.network], one.way, one.scale, one.cpu_ms, one.miou) for one in scores]
    labels = "CPU ms of one thread per image", f"mean IoU (%), {data}{test_set}"
    figure = accuracy_front(points, best, *labels, networks.bars(scores))
    run.write(
        csv=measured.to_csv(index=False, lineterminator="\n"),
        tex=long_latex(ways, caption, "table:tradeoff-networks"),
        md="\n\n".join(parts) + "\n",
        training_csv=ended.to_csv(index=False, lineterminator="\n"),
        training_tex=long_latex(prices, duration, "table:tradeoff-training"),
        **{ending: render(figure, ending) for ending in ("png", "pdf")},
    )
    run.finish()
    print(f"tradeoff networks: {len(scores)} ways, {sum(best)} of them on the front; {this.output('md')}")


def _accuracy(params: Params) -> None:
    from foggy_synscapes.tables.formats import long_latex, long_markdown
    from foggy_synscapes.tradeoff import fog_accuracy, networks

    run, settings = Run(job(params, "tradeoff_accuracy")), params.tradeoff
    models = dict(zip(params.train.networks, map(_model, run.job.inputs("models")), strict=True))
    index, folder = read_index(*run.job.inputs("synscapes")), root(params, "synscapes")
    # The last ones: no list trains on them.
    rows = read_csv(run.job.input("kept"), ("id",))[-settings.images :]
    paths = [synscapes.class_(int(row["id"])) for row in rows]
    expect(index, paths, "synscapes")
    labels = [read_ids(read_checked(folder / path, index[path]), path) for path in paths]
    betas = [float(beta) for beta in settings.betas]
    scores, done = fog_accuracy.measure(models, _read(run.job, rows), labels, betas, 60 * settings.minutes)
    table = fog_accuracy.table(scores)
    caption = (
        f"Shortcuts of fog: mean IoU of the networks of row {settings.row} (seed {params.train.seeds[0]}) on "
        f"{'stand-in ' if params.stand_in else ''}frames of Synscapes, {done} of the last {len(rows)}, each at "
        f"{len(betas)} betas; change from the default way, stored without loss, with its 95 % interval (paired "
        "bootstrap over the frames)."
    )
    shown = networks.printed(table, fog_accuracy.COLUMNS)
    run.write(
        csv=table.to_csv(index=False, lineterminator="\n"),
        tex=long_latex(shown, caption, "table:tradeoff-accuracy"),
        md="\n\n".join([caption, fog_accuracy.paragraph(scores), long_markdown(shown)]) + "\n",
    )
    run.finish()
    print(f"tradeoff accuracy: {len(fog_accuracy.shortcuts()) - 1} shortcuts on {done} frames; {run.job.output('md')}")


def _frames(job: Job) -> list[fog.Frame]:
    """The first kept frames."""
    asked = job.params.tradeoff.frames
    rows = read_csv(job.input("kept"), ("id",))[:asked]
    if len(rows) < asked:
        raise FoggyError(f"tradeoff.frames: asks for {asked} frames, but the filter kept {len(rows)}")
    return _read(job, rows)


def _read(job: Job, rows: list[dict[str, str]]) -> list[fog.Frame]:
    """Image, planar depth in metres and camera of kept frames."""
    index, folder = read_index(*job.inputs("synscapes")), root(job.params, "synscapes")
    clear = [read_frame(folder, int(row["id"]), index) for row in rows]
    return [(one.image, one.depth, synscapes.camera_of(row)) for one, row in zip(clear, rows, strict=True)]


def _samples(job: Job, models: dict[str, "Model"]) -> tuple[list["Sample"], int]:
    """Images and labelIds of the test set, as many as the params allow for, at even distances; and how many it has."""
    from foggy_synscapes.tradeoff.networks import affordable

    settings, name = job.params.tradeoff, job.params.tradeoff.test_set
    index, folder = read_index(job.input("index")), root(job.params, name)
    pairs = DATASETS[name].tested(folder, index, job.params.scenes)
    expect(index, [path for pair in pairs for path in pair], name)

    def read(image: str, label: str) -> "Sample":
        data = (read_checked(folder / path, index[path]) for path in (image, label))
        return read_rgb(next(data), str(folder / image)), read_ids(next(data), str(folder / label))

    count = affordable(models, read(*pairs[0])[0], settings.scales, 60 * settings.minutes)
    if count < 1:
        raise FoggyError(f"tradeoff.minutes: {settings.minutes:g} is too short for a single image. Allow for more.")
    count = min(count, settings.images, len(pairs))
    return [read(*pairs[number * len(pairs) // count]) for number in range(count)], len(pairs)


def _model(path: Path) -> "Model":
    from foggy_synscapes.networks.weights import load_model

    try:
        return load_model(read_bytes(path, "model", limit=LARGEST_WEIGHTS))
    except ValueError as error:
        raise FoggyError(f"{path}: {error}") from error


def _costs(job: Job, models: dict[str, Path], lists: dict[str, Path], reader: Reader) -> list["Cost"]:
    """What fine-tuning each network on each list of purely synthetic images costs, and what it scores."""
    from foggy_synscapes.tradeoff.training import Cost, seconds_per_step
    from foggy_synscapes.training.learner import Arithmetic

    settings, train = job.params.tradeoff, job.params.train
    arithmetic = Arithmetic("cpu", train.precision, train.memory_format)
    seconds: dict[tuple[str, Policy], float] = {}
    costs = []
    for name, path in models.items():
        for row in [row for row in job.params.subset.kinds()["pure"] if row in train.rows]:
            policy, schedule = train.policy(name, row), train.rows[row] or train.network(name).baseline
            if policy is None or schedule is None:
                continue  # a model that is taken as it is
            samples = PairDataset(lists[row], reader, train.cache * 2**20, composite)
            if (name, policy) not in seconds:
                # An iteration takes as long on any list.
                seconds[name, policy] = seconds_per_step(_model(path), policy, arithmetic, samples, settings.steps)
            found = read_scores(run_file(METRICS, settings.test_set, name, row, train.seeds[0]))
            iterations = schedule.length.steps(samples.count, policy.batch)
            miou = found["mean_iou"]["annotated"] if found is not None else None
            costs.append(Cost(name, row, samples.count, iterations, seconds[name, policy], miou))
    return costs
