"""A model card: what a trained model is, what it was trained on and how, what it scores, what it is for, in Markdown.

Sections follow Mitchell et al., Model Cards for Model Reporting, 2019. All values come from run records and scores.
"""

from typing import Any

from foggy_synscapes import __version__
from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params import STAND_IN, Params
from foggy_synscapes.provenance.runs import leaves, read_run, state
from foggy_synscapes.results import LIST, METRICS, MODEL, run_file
from foggy_synscapes.scoring.metrics import read_scores
from foggy_synscapes.tables.table import round_half_up

MISSING = "--"


def model_card(params: Params, network: str, row: str, seed: str) -> str:
    """The card of one trained model, as Markdown; equal results give equal cards.

    params : those that the model was trained with; network, row, seed : as in the params, e.g. bisenet, FS-498, 0

    Raises FoggyError if the model was not trained, or is not what its record says.
    """
    model = run_file(MODEL, network=network, row=row, seed=seed)
    record = read_run(model.with_name("run.json"))
    digest = record["outputs"].get(model.as_posix(), "")
    if (found := state(model, digest)) != "unchanged":
        raise FoggyError(
            f"{model}: {found}, so no card is written of it. `foggy verify` names all such files; train it again."
        )
    title = NETWORKS[network].title
    parts = [
        f"# Model card: {title}, row {row}, seed {seed}",
        "",
        f"`{model}`, SHA-256 `{digest}`, made by Foggy Synscapes {__version__}.",
        "",
        "## What it is",
        f"{title} labels each pixel of a street scene with one of the 19 classes of Cityscapes. Input: an 8-bit RGB",
        f"image; output: one trainId per pixel. `foggy export --network {network} --row {row} --seed {seed} --out",
        "model.onnx` writes it as an ONNX graph that holds its preprocessing.",
        "",
        "## What it was trained on",
        *_trained_on(params, record, row),
        "",
        "## What it scores",
        *_scores(params, network, row, seed),
        "",
        "## How it was trained",
        "`" + " ".join(record["command"]) + "`, with these params:",
        "",
        *_table(["key", "value"], [[f"`{key}`", str(value)] for key, value in leaves(record["params"])]),
        "",
        "Versions: " + ", ".join(f"{name} {version}" for name, version in sorted(record["versions"].items())) + ".",
        f"Instruction set: {record['instructions']['machine']}, {record['instructions']['extensions']}.",
        "On another instruction set or another GPU the same command gives other bytes and slightly other scores.",
        "",
        "## What it is for, and what it is not for",
        "For research on labelling foggy scenes, and for comparison with models that were trained on other images. It",
        "was not tested for use in a vehicle, and no decision about people's safety should rest on it. Classes with",
        "few pixels in the training images have low scores; the table above has each.",
        *(_of_stand_in() if STAND_IN in params.scenes.roots.values() else []),
        "",
        "## Licence",
        "The licence of this software does not cover the training images: each dataset's terms hold for what is made",
        "of it.",
    ]
    return "\n".join(parts) + "\n"


def _trained_on(params: Params, record: dict[str, Any], row: str) -> list[str]:
    """The lists, how long they are, of which datasets their images are, and the weights that were started from."""
    lines = []
    for kind in ("train", "validation"):
        path = run_file(LIST, row=row).with_name(f"{kind}.csv")
        images = [line["image"] for line in read_csv(str(path))]
        counts: dict[str, int] = {}
        for image in images:
            place = image.partition(":")[0]
            counts[place] = counts.get(place, 0) + 1
        of = ", ".join(f"{count:,} of {_name(place, params)}" for place, count in sorted(counts.items()))
        lines.append(f"- {kind}: {len(images):,} images ({of}); list `{path}`")
    starts = [name for name in record["inputs"] if name.endswith(".safetensors")]
    lines.append(f"- started from: {', '.join(f'`{name}`' for name in starts) or 'random weights'}")
    return lines


def _name(place: str, params: Params) -> str:
    """What a list's images are of: a dataset, or our foggy images."""
    if place not in DATASETS:
        return f"Foggy Synscapes made here{' from stand-in images' if _is_stand_in(params, 'synscapes') else ''}"
    return f"{DATASETS[place].title}{' (stand-in)' if _is_stand_in(params, place) else ''}"


def _is_stand_in(params: Params, dataset: str) -> bool:
    return params.scenes.roots.get(dataset) == STAND_IN


def _scores(params: Params, network: str, row: str, seed: str) -> list[str]:
    """IoU of each class and both means on every test set, in percent; what was not scored or is not defined is `--`."""
    names, columns = ["mean IoU annotated", "mean IoU as published"], []
    for test_set in params.evaluate.test_sets:
        path = run_file(METRICS, test_set, network, row, seed)
        scores = read_scores(path) if path.is_file() else None
        if scores:
            names = [*names[:2], *(entry["name"] for entry in scores["classes"])]
            means = [scores["mean_iou"][kind] for kind in ("annotated", "as_published")]
            columns.append([*means, *(entry["iou"] for entry in scores["classes"])])
        else:
            columns.append([])
    rows = [
        [name, *(_number(column[number] if column else None) for column in columns)]
        for number, name in enumerate(names)
    ]
    return [
        "IoU in percent. Of one seed: another seed or processor gives scores some points apart.",
        "",
        *_table(["score", *(_name(test_set, params) for test_set in params.evaluate.test_sets)], rows),
    ]


def _number(value: float | None) -> str:
    return MISSING if value is None else str(round_half_up(value))


def _of_stand_in() -> list[str]:
    return [
        "",
        "**Some of its images are stand-ins**: synthetic streets drawn in place of datasets that may not be",
        "redistributed. Such a model shows that the experiment runs, and says nothing about real streets or real fog.",
    ]


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]
