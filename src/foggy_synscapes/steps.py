"""The table of steps: for each kind of job its command, what it reads and writes, and what else decides its bytes.

Commands, run records, the rules of Snakemake and dvc.yaml all take these from here; paths that several of them know are
in `results`. In templates `{row}` is the value of a wildcard and `{row.beta}` a value of its entry in the params.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets import DATASETS, test_settings
from foggy_synscapes.errors import UsageError
from foggy_synscapes.figures import FIGURES
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.jobs import Each, Job, Step, Template, Values, listed
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params import BASELINE, Params
from foggy_synscapes.registry import Registry, plugin_files
from foggy_synscapes.results import (
    CODE,
    FOG,
    INDEX,
    KEPT,
    LIST,
    METRICS,
    MODEL,
    PAPERS_TABLE,
    RESULTS,
    RUN,
    SCENES,
    SCORED,
    TABLE,
    TRAINED,
    index,
)
from foggy_synscapes.standin.layouts import STAND_INS
from foggy_synscapes.subsets import KINDS

REGISTRIES: dict[str, Registry] = {
    "datasets": DATASETS,
    "figures": FIGURES,
    "fog_models": MODELS,
    "networks": NETWORKS,
    "stand_ins": STAND_INS,
    "subsets": KINDS,
}
NETWORK, SEED, FOG_MODEL = "train.networks", "train.seeds", "fog.model"
ROWS = ("train.from_weights", "train.from_baseline")
RUNS = {"network": (NETWORK,), "row": ROWS, "seed": (SEED,)}
AIRLIGHT_KEYS = ("fog.frames", "fog.blue_airlight", "scenes.shard_frames")
CAPS = ("images", "minutes")
DEVICE_KEYS = ("device", "gpu")
TRAIN_KEYS = DEVICE_KEYS + tuple(
    f"train.{key}" for key in ("threads", "device", "precision", "memory_format", "compile", "curve")
)
NETWORK_KEYS = tuple(f"train.{{network}}.{key}" for key in ("backbone", "width", "decoder"))


def _files(path: str, *endings: str) -> dict[str, Template]:
    return {ending: f"{path}.{ending}" for ending in endings}


def _index(dataset: str) -> Template:
    """The index of a dataset, all parts of it."""
    key = DATASETS[dataset].parts
    return Each(f"{INDEX}/{dataset}", "{part}.csv", {"part": (key,)}) if key else index(dataset)


def _indexes(*datasets: str) -> dict[str, Template]:
    return {dataset: _index(dataset) for dataset in datasets}


SOURCES: dict[str, Callable[[], dict[str, Template]]] = {
    "frames": lambda: {**_indexes("synscapes"), "kept": KEPT},
    "refined": lambda: _indexes("cityscapes", "foggy_cityscapes"),
    "filter": lambda: {"filter": f"{RESULTS}/filter/frames.csv"},
    "fog": lambda: {
        "kept": KEPT,
        "fog": Each(f"{FOG}/beta_{{row.beta}}", "{shard}.csv", {"shard": ("scenes.shards",)}),
    },
    "curves": lambda: {"curves": Each(f"{RESULTS}/train", f"{RUN}/curves.csv", RUNS)},
    "metrics": lambda: {"metrics": Each(f"{RESULTS}/evaluate/{{test_set}}", f"{RUN}/metrics.json", RUNS)},
    "predictions": lambda: {"predictions": Each(f"{RESULTS}/evaluate/{{test_set}}", f"{RUN}/predictions.tar", RUNS)},
    "images": lambda: {"images": index("{test_set}")},
}
"""What lists and figures may read beside the indexes of datasets, by the names under which they declare it."""


def _sources(names: Iterable[str]) -> dict[str, Template]:
    found = [SOURCES[name]() if name in SOURCES else _indexes(name) for name in names]
    return {key: template for each in found for key, template in each.items()}


def drawn_by(dataset: str) -> list[str]:
    """Params keys that decide the pixels of a dataset's stand-in; none where it has no stand-in."""
    if dataset not in STAND_INS:
        return []
    return [f"scenes.stand_in.{key}" for key in ("seed", "size", dataset, *STAND_INS[dataset].others)]


def _scenes(dataset: str) -> Step:
    entry, drawn = DATASETS[dataset], drawn_by(dataset)
    return Step(
        name=f"scenes_{dataset}",
        word="scenes",
        text=f"List what {entry.title} holds, drawn first where its root says so.",
        command=f"scenes --dataset {dataset}",
        outputs={
            "index": _index(dataset),
            "record": f"{INDEX}/{dataset}/run.json",
            "readme": f"{SCENES}/{dataset}/README.txt",
        },
        folders=(f"{SCENES}/{dataset}", f"{INDEX}/{dataset}"),
        params=(f"scenes.roots.{dataset}", *entry.settings, *drawn),
        asked=f"scenes.roots.{dataset}",
        code=(f"datasets.{dataset}", *([f"stand_ins.{dataset}"] if drawn else [])),
        minutes=12 * 60,
    )


def _filter() -> Step:
    return Step(
        name="filter",
        word="filter",
        text="Keep frames by their metadata.",
        command="filter",
        inputs=_indexes("synscapes"),
        outputs={"frames": f"{RESULTS}/filter/frames.csv", "kept": KEPT, "record": f"{RESULTS}/filter/run.json"},
        params=("filter", "scenes.shards"),
    )


def _airlight() -> Step:
    airlight = f"{FOG}/airlight/{{shard}}"
    return Step(
        name="fog_airlight",
        word="fog",
        text="Estimate the airlight of a shard's frames, once for all betas.",
        command="fog --airlight --shard {shard}",
        wildcards={"shard": "scenes.shards"},
        inputs={"index": index("synscapes", "{shard}"), "kept": KEPT},
        outputs={"airlight": f"{airlight}.csv", "record": f"{airlight}.run.json"},
        params=AIRLIGHT_KEYS,
        minutes=120,
    )


def _fog() -> Step:
    before, images = _airlight(), f"{FOG}/beta_{{beta}}/{{shard}}"
    return Step(
        name="fog",
        word="fog",
        text="Render the foggy images of one shard at one beta.",
        command="fog --beta {beta} --shard {shard}",
        wildcards={"beta": "fog.betas", "shard": "scenes.shards"},
        inputs={**before.inputs, "airlight": before.outputs["airlight"]},
        outputs={"shard": f"{images}.tar", "manifest": f"{images}.csv", "record": f"{images}.run.json"},
        params=(*AIRLIGHT_KEYS, FOG_MODEL, "fog.geometry", "fog.png_level", "fog.render"),
        code=(f"fog_models.*{FOG_MODEL}",),
        minutes=120,
    )


def _lists() -> dict[str, Template]:
    return {"train": LIST, "validation": f"{RESULTS}/subset/{{row}}/validation.csv"}


def _subset(kind: str) -> Step:
    entry = KINDS[kind]
    return Step(
        name=f"subset_{kind}",
        word="subset",
        text=f"Make {entry.text}.",
        command="subset --row {row}",
        wildcards={"row": f"subset.{kind}"},
        inputs=_sources(entry.reads),
        outputs={**_lists(), "record": f"{RESULTS}/subset/{{row}}/run.json"},
        params=(f"subset.{kind}.{{row}}", *entry.keys),
        code=(f"subsets.{kind}",),
        minutes=30,
    )


def fog_shards(params: Params, values: Values) -> list[str]:
    """Shards that hold images of a row's list, which has the hash of each image."""
    entry = params.subset.foggy().get(values["row"])
    return [f"{FOG}/beta_{entry.beta}/{shard}.tar" for shard in params.scenes.shards] if entry else []


def _start_weights(params: Params, values: Values) -> list[str]:
    """The file of start weights where it is there: an experiment can be planned before it is imported."""
    weights = params.train.weights(values["network"], values["row"])
    return [weights] if Path(weights).is_file() else []


def _train(name: str, text: str, row: str, own: tuple[str, ...], **others: Any) -> Step:
    return Step(
        name=name,
        word="train",
        text=text,
        command="train --network {network} --row {row} --seed {seed}",
        wildcards={"network": NETWORK, "row": row, "seed": SEED},
        inputs={**_lists(), **others.pop("start", {})},
        outputs={"model": MODEL, "curves": f"{TRAINED}/curves.csv", "record": f"{TRAINED}/run.json"},
        plots={"curves": {"x": "step", "y": "train_loss"}},
        params=(
            *TRAIN_KEYS,
            "train.rows.{row}",
            *NETWORK_KEYS,
            *(f"train.{{network}}.{key}" for key in own),
        ),
        code=("networks.{network}",),
        waits=fog_shards,
        threads="train.threads",
        megabytes=16_000,
        minutes=7 * 24 * 60,
        gpu=True,
        **others,
    )


def _trainings() -> list[Step]:
    return [
        _train(
            "train_from_weights",
            "Train a network on a list from its own weights.",
            ROWS[0],
            ("baseline", "weights"),
            optional=_start_weights,
            priority=100,  # fine-tunings wait for the baseline
        ),
        _train(
            "train_from_baseline",
            f"Fine-tune the selected snapshot of row {BASELINE} on another list.",
            ROWS[1],
            ("fine_tuning",),
            start={"start": MODEL.replace("{row}", BASELINE)},
        ),
    ]


def _evaluate(row: str) -> Step:
    return Step(
        name=f"evaluate_{row.partition('.')[2]}",
        word="evaluate",
        text=f"Score a model of a row in {row} on one test set.",
        command="evaluate --network {network} --row {row} --seed {seed} --test-set {test_set}",
        wildcards={"test_set": "evaluate.test_sets", "network": NETWORK, "row": row, "seed": SEED},
        inputs={"model": MODEL, "index": index("{test_set}")},
        outputs={"metrics": METRICS, "predictions": f"{SCORED}/predictions.tar", "record": f"{SCORED}/run.json"},
        params=(*DEVICE_KEYS, "evaluate.threads", "evaluate.device", *test_settings()),
        code=("networks.{network}", "datasets.{test_set}"),
        threads="evaluate.threads",
        megabytes=4_000,
        minutes=12 * 60,
        gpu=True,
    )


def _tables() -> Step:
    return Step(
        name="tables",
        word="tables",
        text="Print the scores of all rows on one test set, beside the published ones.",
        command="tables --test-set {test_set}",
        wildcards={"test_set": "evaluate.test_sets"},
        inputs=_sources(["metrics"]),
        outputs={**_files(TABLE, "csv", "tex", "md", "html", "json"), "record": f"{TABLE}.run.json"},
        metrics=("json",),
        params=("tables", "subset.*", "scenes.roots", NETWORK, SEED, *ROWS),
        code=(f"networks.*{NETWORK}", "datasets.{test_set}"),
        minutes=30,
    )


def in_the_paper(params: Params) -> dict[str, list[str]]:
    """Test sets, networks and rows of the tables of which the paper prints numbers, by the names of wildcards."""
    from foggy_synscapes.tables import published

    lines = [line for test_set in published.TEST_SETS for line in published.load(test_set).index]
    titles, rows = ({line[k] for line in lines} for k in (0, 1))
    return {
        "test_set": published.TEST_SETS,
        "network": [name for name in params.train.networks if NETWORKS[name].title in titles],
        "row": [entry.row for entry in params.tables.rows if entry.row in rows],
    }


def _tables_paper() -> Step:
    whole = _tables()
    return replace(
        whole,
        name="tables_paper",
        text="Print the scores of the rows that the paper has, and of no others.",
        command="tables --test-set {test_set} --paper",
        outputs={
            **_files(PAPERS_TABLE, "csv", "tex", "md", "html", "json"),
            "record": f"{PAPERS_TABLE}.run.json",
        },
        default=False,
        only=in_the_paper,
    )


def _figure(name: str) -> Step:
    entry = FIGURES[name]
    place = f"{name}_{{test_set}}" if entry.of_test_set else name
    figure = f"{RESULTS}/figures/{place}"
    return Step(
        name=f"figures_{name}",
        word="figures",
        text=entry.text,
        command=f"figures --figure {place}",
        wildcards={"test_set": "evaluate.test_sets"} if entry.of_test_set else {},
        inputs=_sources(entry.inputs),
        outputs={**_files(figure, "png", "pdf"), "record": f"{figure}.run.json"},
        params=("figures", *entry.keys, *(test_settings() if "images" in entry.inputs else ())),
        code=(
            f"figures.{name}",
            *((f"networks.*{NETWORK}", "datasets.{test_set}") if entry.of_test_set else ()),
            *((f"fog_models.*{FOG_MODEL}",) if FOG_MODEL in entry.keys else ()),
        ),
        megabytes=4_000,
    )


def _stability() -> Step:
    return Step(
        name="stability",
        word="stability",
        text="Check the numbers at the extremes of their inputs.",
        command="stability",
        outputs={
            **_files(f"{RESULTS}/stability/stability", "csv", "tex", "md", "png", "pdf"),
            "record": f"{RESULTS}/stability/run.json",
        },
        params=("stability",),
        megabytes=2_000,
    )


def _tradeoff_fog() -> Step:
    made = f"{RESULTS}/tradeoff/fog"
    keys = ("tradeoff.betas", "tradeoff.frames", "tradeoff.repeats", "scenes.roots.synscapes", "scenes.shards")
    return Step(
        name="tradeoff_fog",
        word="tradeoff",
        text="Measure ways of computing fog.",
        command="tradeoff --part fog",
        inputs=_sources(["frames"]),
        outputs={**_files(made, "csv", "tex", "md", "png", "pdf"), "record": f"{made}.run.json"},
        params=keys,
        megabytes=4_000,
        minutes=120,
        default=False,
    )


def _tradeoff_networks() -> Step:
    made, row, first = f"{RESULTS}/tradeoff", "tradeoff.row", {"network": (NETWORK,), "seed": (f"{SEED}.0",)}
    test_set = {"test_set": ("tradeoff.test_set",)}
    keys = tuple(f"tradeoff.{key}" for key in ("row", "test_set", "scales", "calibration", "steps", *CAPS, "tolerance"))
    return Step(
        name="tradeoff_networks",
        word="tradeoff",
        text="Measure ways of computing the trained networks, and what their training costs.",
        command="tradeoff --part networks",
        inputs={
            "index": Each(INDEX, "{test_set}/all.csv", test_set),
            "lists": Each(f"{RESULTS}/subset", "{row}/train.csv", {"row": (row, "subset.pure")}),
            # Training images are read too, to calibrate 8 bits and to time training.
            "shards": Each(FOG, "beta_{beta}/{shard}.tar", {"beta": ("fog.betas",), "shard": ("scenes.shards",)}),
            "models": Each(f"{RESULTS}/train", f"{RUN}/model.safetensors", {**first, "row": (row,)}),
            "metrics": Each(
                f"{RESULTS}/evaluate",
                f"{{test_set}}/{RUN}/metrics.json",
                {**test_set, **first, "row": ("subset.pure",)},
            ),
        },
        outputs={
            **_files(f"{made}/networks", "csv", "tex", "md", "png", "pdf"),
            **{f"training_{ending}": f"{made}/training.{ending}" for ending in ("csv", "tex")},
            "record": f"{made}/networks.run.json",
        },
        params=(*keys, "scenes.roots", *test_settings(), "subset.pure", "train"),
        code=(f"networks.*{NETWORK}", "datasets.*tradeoff.test_set"),
        megabytes=8_000,
        minutes=600,
        default=False,
    )


def _tradeoff_accuracy() -> Step:
    made = f"{RESULTS}/tradeoff/accuracy"
    models = {"network": (NETWORK,), "row": ("tradeoff.row",), "seed": (f"{SEED}.0",)}
    return Step(
        name="tradeoff_accuracy",
        word="tradeoff",
        text="Score the trained networks on fog that is made in cheaper and rougher ways.",
        command="tradeoff --part accuracy",
        inputs={
            **_sources(["frames"]),
            "models": Each(f"{RESULTS}/train", f"{RUN}/model.safetensors", models),
        },
        outputs={**_files(made, "csv", "tex", "md"), "record": f"{made}.run.json"},
        params=(
            *(f"tradeoff.{key}" for key in ("row", "betas", *CAPS)),
            "scenes.roots",
            "scenes.shards",
            NETWORK,
            SEED,
        ),
        code=(f"networks.*{NETWORK}",),
        megabytes=8_000,
        minutes=120,
        default=False,
    )


def steps() -> list[Step]:
    """All kinds of jobs, in their order."""
    return _steps(tuple(plugin_files()))


@cache
def _steps(_plugins: tuple[Path, ...]) -> list[Step]:
    return [
        *(_scenes(dataset) for dataset in DATASETS),
        _filter(),
        _airlight(),
        _fog(),
        *(_subset(kind) for kind in KINDS),
        *_trainings(),
        *(_evaluate(row) for row in ROWS),
        _tables(),
        _tables_paper(),
        *(_figure(name) for name in FIGURES),
        _stability(),
        _tradeoff_fog(),
        _tradeoff_networks(),
        _tradeoff_accuracy(),
    ]


def of(word: str) -> list[Step]:
    """The kinds of jobs of a word."""
    return [step for step in steps() if step.word == word]


def job(params: Params, name: str, **values: str) -> Job:
    """The job of a step, or of the step of a word whose rows have `row`; raises UsageError if there is none."""
    for step in steps():
        fits = step.name == name or (step.word == name and set(step.wildcards) == {*values})
        if fits and values.get("row", "") in (
            "",
            *listed(params, *([step.wildcards["row"]] if "row" in values else [])),
        ):
            return Job(step, params, values)
    said = ", ".join(f"{key} {value}" for key, value in values.items())
    raise UsageError(f"{name} {said}: the params have no such job")


def code_file(step: Step, values: Values) -> str:
    """Where DVC finds the digest of the code of a job."""
    return "/".join([CODE, step.name, *(values[name] for name in step.code_wildcards())]) + ".txt"
