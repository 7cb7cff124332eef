"""figures: the pictures that people want first."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import foggy_cityscapes, synscapes
from foggy_synscapes.datasets.index import expect, index_path, read_index
from foggy_synscapes.datasets.scores import read_scores, scores_path
from foggy_synscapes.datasets.test_sets import labelled_pairs
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.frame import foggy_frame
from foggy_synscapes.fog.optics import meteorological_optical_range
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import read_depth, read_ids, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.labels import CLASSES, IGNORE, to_train_ids
from foggy_synscapes.params import STAND_IN, Params, load, root
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.iou import iou, mean_annotated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HELP = "Draw a figure: fog at each beta, FC against FS, sky contrast, predictions of each row, training curves."
FOLDER = Path("results/figures")
BASELINE = "C"
KEPT = Path("results/filter/kept.csv")
FRAMES = Path("results/filter/frames.csv")
SKY_CONTRAST = "sky_contrast"
TEST_SETS = {"foggy_driving": "Foggy Driving", "foggy_zurich": "Foggy Zurich", "cityscapes": "clear Cityscapes, val"}
OF_TEST_SET = ("predictions", "class_change", "confusion")
NETWORKS = {"refinenet": "RefineNet", "bisenet": "BiSeNet"}
RUNS = ("train.networks", "train.seeds", "train.from_weights", "train.from_baseline", "tables.rows.row")
OF_FRAMES = ("fog.geometry", "scenes.refined_list", "scenes.shards")
# Params that each kind of figure reads beside its own section.
READ = {
    "beta_strip": OF_FRAMES,
    "fc_against_fs": OF_FRAMES,
    "sky_contrast": ("filter", "scenes.roots"),
    "curves": RUNS,
    "predictions": (*RUNS, "scenes.roots", "scenes.zurich_list"),
    "class_change": (*RUNS, "scenes.roots"),
    "confusion": (*RUNS, "scenes.roots"),
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    names = ["beta_strip", "fc_against_fs", "sky_contrast", "curves"]
    names += [f"{kind}_{name}" for name in TEST_SETS for kind in OF_TEST_SET]
    parser.add_argument("--figure", required=True, metavar="NAME", choices=names, help=", ".join(names))


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    figures(load(args.params), args.figure)


def figures(params: Params, name: str) -> None:
    """Draw one figure and write it as PNG and PDF to results/figures.

    Raises
    ------
    FoggyError
        If what it shows is missing, damaged or not as listed.
    """
    from foggy_synscapes.figures.style import render

    inputs: dict[str, str] = {}
    draw: dict[str, Callable[[Params, dict[str, str]], Figure]] = {
        "beta_strip": _beta_strip,
        "fc_against_fs": _fc_against_fs,
        "sky_contrast": _sky_contrast,
        "curves": _curves,
    }
    draw_of_test_set = {"predictions": _predictions, "class_change": _class_change, "confusion": _confusion}
    kind = next((kind for kind in OF_TEST_SET if name.startswith(kind)), name)
    if kind in draw:
        figure = draw[kind](params, inputs)
    else:
        figure = draw_of_test_set[kind](params, inputs, name.removeprefix(f"{kind}_"))
    outputs = [FOLDER / f"{name}.{ending}" for ending in ("png", "pdf")]
    for path in outputs:
        write_bytes(path, render(figure, path.suffix[1:]))
    write_run(
        FOLDER / f"{name}.run.json",
        command=["foggy", "figures", "--figure", name],
        params=recorded(params, "figures", *READ[kind]),
        inputs=inputs,
        outputs=outputs,
    )
    print(f"figures {name}: {outputs[0]}, {outputs[1]}")


@dataclass(frozen=True)
class Frame:
    """A kept Synscapes frame: id, clear image uint8 (H, W, 3), planar depth in metres (H, W), camera."""

    number: int
    clear: np.ndarray
    depth: np.ndarray
    camera: Camera

    def foggy(self, betas: list[str], geometry: str) -> list[np.ndarray]:
        """Foggy images, uint8 (H, W, 3), one for each beta in 1/m."""
        try:
            return foggy_frame(self.clear, self.depth, self.camera, [float(beta) for beta in betas], geometry)
        except ValueError as error:
            raise FoggyError(f"frame {self.number}: {error}") from error


def _frames(params: Params, count: int, inputs: dict[str, str]) -> list[Frame]:
    """The first kept frames."""
    names = [f"synscapes/{shard}" for shard in params.scenes.shards]
    inputs.update(checked_inputs([KEPT, *(index_path(name) for name in names)]))
    index, folder = read_index(*names), root(params, "synscapes")
    frames = []
    for row in read_csv(KEPT, ("id",))[:count]:
        number = int(row["id"])
        paths = synscapes.rgb(number), synscapes.depth(number)
        expect(index, paths, "synscapes")
        image, depth = (read_checked(folder / path, index[path]) for path in paths)
        camera = synscapes.camera_of(row)
        frames.append(Frame(number, read_rgb(image, paths[0]), read_depth(depth, paths[1]), camera))
    return frames


def _beta_strip(params: Params, inputs: dict[str, str]) -> "Figure":
    """Two frames in clear weather and at each beta, as in the paper's figure 3."""
    from foggy_synscapes.figures.panels import grid

    betas = params.figures.betas
    sights = [f"β = {beta} / m, sight {meteorological_optical_range(float(beta)):.0f} m" for beta in betas]
    lines = [
        [frame.clear, *frame.foggy(betas, params.fog.geometry)]
        for frame in progress(_frames(params, 2, inputs), "figures beta_strip", unit="frame")
    ]
    return grid(lines, ["clear", *sights])


def _fc_against_fs(params: Params, inputs: dict[str, str]) -> "Figure":
    """Foggy Synscapes above Foggy Cityscapes at the same beta, as in the paper's figure 4."""
    from foggy_synscapes.figures.panels import grid

    beta, count = params.figures.comparison_beta, params.figures.images
    purely = [frame.foggy([beta], params.fog.geometry)[0] for frame in _frames(params, count, inputs)]
    name, folder = "foggy_cityscapes/all", root(params, "foggy_cityscapes")
    inputs.update(checked_inputs([index_path(name), index_path("cityscapes/all")]))
    index = read_index(name)
    refined = foggy_cityscapes.read_refined(folder, params.scenes.refined_list, index)["train"][:count]
    paths = [foggy_cityscapes.image(frame, beta) for frame in refined]
    expect(index, paths, "foggy_cityscapes")
    partly = [read_rgb(read_checked(folder / path, index[path]), path) for path in paths]
    shown = min(len(purely), len(partly))
    title = f"β = {beta} / m on exact depth (above), on completed disparity (below)"
    return grid([purely[:shown], partly[:shown]], [""] * shown, ["Foggy Synscapes", "Foggy Cityscapes"], title=title)


def _sky_contrast(params: Params, inputs: dict[str, str]) -> "Figure":
    """Distribution of the scene key by which the paper would filter (section IV.B), and the filter's cut."""
    from foggy_synscapes.figures.histogram import cut_histogram

    inputs.update(checked_inputs([FRAMES]))
    frames = read_csv(FRAMES, (SKY_CONTRAST, "kept"))
    values, kept = (
        [convert(frame[key]) for frame in frames] for key, convert in ((SKY_CONTRAST, float), ("kept", int))
    )
    cuts = [
        (kind, getattr(rule, kind))
        for rule in params.filter.rules
        for kind in ("minimum", "maximum")
        if rule.key == SKY_CONTRAST and getattr(rule, kind) is not None
    ]
    stand_in = " (stand-in)" if params.scenes.roots.synscapes == STAND_IN else ""
    return cut_histogram(values, kept, cuts, "sky_contrast", f"Synscapes{stand_in}: contrast of the sky of each frame")


def _curves(params: Params, inputs: dict[str, str]) -> "Figure":
    """Training and validation loss of each row, of the first seed."""
    from foggy_synscapes.figures.curves import curves

    seed = params.train.seeds[0]
    panels: dict[str, dict] = {}
    for network in params.train.networks:
        panels[NETWORKS[network]] = {}
        for row in _rows(params):
            path = Path(f"results/train/{network}/{row}/seed-{seed}/curves.csv")
            inputs.update(checked_inputs([path]))
            table = read_csv(path, ("step", "train_loss", "validation_loss"))
            last = max((int(line["step"]) for line in table), default=1)
            panels[NETWORKS[network]][row] = tuple(
                [(100 * int(line["step"]) / last, float(line[name])) for line in table if line[name]]
                for name in ("train_loss", "validation_loss")
            )
    return curves(panels)


def _rows(params: Params) -> list[str]:
    """Rows that are trained, in the order of the tables."""
    trained = [*params.train.from_weights, *params.train.from_baseline]
    printed = [entry.row for entry in params.tables.rows]
    return [row for row in printed if row in trained] + [row for row in trained if row not in printed]


def _predictions(params: Params, inputs: dict[str, str], test_set: str) -> "Figure":
    """Test images, their ground truth and the predictions of each row, with the mean IoU of each single image."""
    from foggy_synscapes.figures.panels import colour, grid

    inputs.update(checked_inputs([index_path(f"{test_set}/all")]))
    index, folder = read_index(f"{test_set}/all"), root(params, test_set)
    pairs = spread(labelled_pairs(test_set, folder, index, params.scenes.zurich_list), params.figures.images)
    expect(index, [path for pair in pairs for path in pair], test_set)
    clear = [read_rgb(read_checked(folder / image, index[image]), image) for image, _ in pairs]
    truth = []
    for _, label in pairs:
        ids = read_ids(read_checked(folder / label, index[label]), label)
        try:
            truth.append(to_train_ids(ids, label))
        except ValueError as error:
            raise FoggyError(str(error)) from error
    rows, seed = _rows(params), params.train.seeds[0]
    lines, names, notes = [], [], []
    for network in params.train.networks:
        block = [[image, colour(ids)] for image, ids in zip(clear, truth, strict=True)]
        scores = [["", ""] for _ in pairs]
        for row in rows:
            path = Path(f"results/evaluate/{test_set}/{network}/{row}/seed-{seed}/predictions.tar")
            inputs.update(checked_inputs([path]))
            with Shard(path) as shard:
                for number, (image, _) in enumerate(pairs):
                    predicted = read_ids(shard.read(image), f"{path}#{image}")
                    # The paper paints unlabelled pixels of predictions too; only the score leaves them out.
                    block[number].append(colour(predicted))
                    matrix = confusion_matrix(truth[number], predicted, len(CLASSES), IGNORE)
                    scores[number].append(f"{100 * mean_annotated(iou(matrix)):.0f}")
        lines += block
        notes += scores
        names += [NETWORKS[network]] * len(pairs)
    title = f"{_title(params, test_set)}: predictions of each row; in the corner, mean IoU of the image in percent"
    return grid(lines, ["image", "ground truth", *rows], names, notes, legend=True, title=title)


def _class_change(params: Params, inputs: dict[str, str], test_set: str) -> "Figure":
    """Change of each class's IoU against the baseline C, of the first seed."""
    from foggy_synscapes.figures.scores import class_change

    panels, annotated = {}, 0
    for network, runs in _scores(params, inputs, test_set).items():
        if BASELINE not in runs:
            raise FoggyError(f"figures: no scores of row {BASELINE} of {network} on {test_set}; evaluate it first")
        annotated = runs[BASELINE]["annotated_classes"]
        ious = {row: [entry["iou"] for entry in run["classes"]] for row, run in runs.items()}
        for row, run in runs.items():
            ious[row].append(run["mean_iou"]["annotated"])
        panels[NETWORKS[network]] = {
            row: [None if a is None or b is None else a - b for a, b in zip(values, ious[BASELINE], strict=True)]
            for row, values in ious.items()
            if row != BASELINE
        }
    return class_change(panels, [*CLASSES, f"mean ({annotated} annotated)"], _title(params, test_set), BASELINE)


def _confusion(params: Params, inputs: dict[str, str], test_set: str) -> "Figure":
    """Confusion matrix of each network's best row, of the first seed."""
    from foggy_synscapes.figures.scores import confusion

    panels = {}
    for network, runs in _scores(params, inputs, test_set).items():
        best = max(runs, key=lambda row: runs[row]["mean_iou"]["annotated"])
        matrix = [*zip(*runs[best]["confusion"], strict=True), runs[best]["unlabelled_predictions"]]
        panels[f"{NETWORKS[network]}, {best} (highest mean IoU)"] = np.array(matrix, np.int64).T
    return confusion(panels, CLASSES, _title(params, test_set))


def _scores(params: Params, inputs: dict[str, str], test_set: str) -> dict[str, dict[str, dict]]:
    """Metrics by network and row, of the first seed, of the runs that exist."""
    found: dict[str, dict[str, dict]] = {}
    for network in params.train.networks:
        paths = {row: scores_path(test_set, network, row, params.train.seeds[0]) for row in _rows(params)}
        made = {row: path for row, path in paths.items() if path.is_file()}
        inputs.update(checked_inputs(made.values()))
        runs = {row: read_scores(path) for row, path in made.items()}
        found[network] = {row: run for row, run in runs.items() if run is not None}
        if not found[network]:
            raise FoggyError(f"figures: no scores of {network} on {test_set}; run `foggy evaluate` first")
    return found


def _title(params: Params, test_set: str) -> str:
    return TEST_SETS[test_set] + (" (stand-in)" if params.stand_in else "")


def spread(items: list, count: int) -> list:
    """`count` items at even distances, the first one included.

    >>> spread(list(range(10)), 4)
    [0, 2, 5, 7]
    """
    count = min(count, len(items))
    return [items[number * len(items) // count] for number in range(count)]
