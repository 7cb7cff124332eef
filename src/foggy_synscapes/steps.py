"""The table of steps: for each kind of job its command, what it reads and writes, and what else decides its bytes.

Commands, run records, the rules of Snakemake and dvc.yaml all take these from here; paths that several of them know are
in `results`. In templates `{row}` is the value of a wildcard and `{row.beta}` a value of its entry in the params.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from foggy_synscapes import measured_steps, stereo_steps
from foggy_synscapes.datasets import DATASETS, test_settings
from foggy_synscapes.errors import UsageError
from foggy_synscapes.figures import FIGURES
from foggy_synscapes.figures.figure import RUNS as RUN_KEYS
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.frames.layouts import LAYOUTS
from foggy_synscapes.jobs import Job, Step, Template, Values, listed
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
    SCENES,
    SCORED,
    TABLE,
    TRAINED,
    index,
)
from foggy_synscapes.standin.layouts import STAND_INS
from foggy_synscapes.step_files import FOG_MODEL, FOG_VALUES, NETWORK, ROWS, SEED, files, index_of, indexes, sources
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import ModelledRow

REGISTRIES: dict[str, Registry] = {
    "datasets": DATASETS,
    "figures": FIGURES,
    "fog_models": MODELS,
    "layouts": LAYOUTS,
    "networks": NETWORKS,
    "stand_ins": STAND_INS,
    "subsets": KINDS,
}
AIRLIGHT_KEYS = ("fog.frames", "fog.blue_airlight", "scenes.shard_frames")
DEVICE_KEYS = ("device", "gpu")
TRAIN_KEYS = DEVICE_KEYS + tuple(
    f"train.{key}" for key in ("threads", "device", "precision", "memory_format", "compile", "curve")
)
NETWORK_KEYS = tuple(f"train.{{network}}.{key}" for key in ("backbone", "width", "decoder"))


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
            "index": index_of(dataset),
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
        inputs=indexes("synscapes"),
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
        params=(*AIRLIGHT_KEYS, FOG_MODEL, FOG_VALUES, "fog.geometry", "fog.png_level", "fog.render"),
        code=(f"fog_models.*{FOG_MODEL}",),
        minutes=120,
    )


def _fog_model() -> Step:
    whole, images = _fog(), f"{FOG}/{{model}}/beta_{{beta}}/{{shard}}"
    return replace(
        whole,
        name="fog_model",
        text="Render the foggy images of one shard at one beta by a further fog model.",
        command="fog --beta {beta} --model {model} --shard {shard}",
        wildcards={"model": "fog.also", **whole.wildcards},
        outputs={"shard": f"{images}.tar", "manifest": f"{images}.csv", "record": f"{images}.run.json"},
        params=tuple(key for key in whole.params if key != FOG_MODEL),
        code=("fog_models.{model}",),
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
        inputs=sources(entry.reads),
        outputs={**_lists(), "record": f"{RESULTS}/subset/{{row}}/run.json"},
        params=(f"subset.{kind}.{{row}}", *entry.keys),
        code=(f"subsets.{kind}",),
        minutes=30,
    )


def fog_shards(params: Params, values: Values) -> list[str]:
    """Shards that hold images of a row's list, which has the hash of each image."""
    entry = params.subset.foggy().get(values["row"])
    folder = f"{FOG}/{entry.model}" if isinstance(entry, ModelledRow) else FOG
    own = [f"{folder}/beta_{entry.beta}/{shard}.tar" for shard in params.scenes.shards] if entry else []
    return own + stereo_steps.made_shards(params, values) + stereo_steps.completed_shards(params, values)


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
        inputs=sources(["metrics"]),
        outputs={**files(TABLE, "csv", "tex", "md", "html", "json"), "record": f"{TABLE}.run.json"},
        metrics=("json",),
        params=("tables", "subset.*", FOG_MODEL, FOG_VALUES, "scenes.roots", NETWORK, SEED, *ROWS),
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
            **files(PAPERS_TABLE, "csv", "tex", "md", "html", "json"),
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
        inputs=sources(entry.inputs),
        outputs={**files(figure, "png", "pdf"), "record": f"{figure}.run.json"},
        asked=entry.asked,
        params=("figures", *entry.keys, *(test_settings() if "images" in entry.inputs else ())),
        code=(
            f"figures.{name}",
            *((f"networks.*{NETWORK}", "datasets.{test_set}") if entry.of_test_set else ()),
            *((f"fog_models.*{FOG_MODEL}",) if FOG_MODEL in entry.keys else ()),
        ),
        megabytes=4_000,
    )


def _view() -> Step:
    page = f"{RESULTS}/view/{{test_set}}"
    return Step(
        name="view",
        word="view",
        text="Make the page on which predictions on one test set are looked at.",
        command="view --results --test-set {test_set}",
        wildcards={"test_set": "evaluate.test_sets"},
        inputs=sources(["images", "metrics", "predictions"]),
        outputs={"page": f"{page}.html", "record": f"{page}.run.json"},
        params=("view", *RUN_KEYS, "scenes.roots", *test_settings()),
        code=(f"networks.*{NETWORK}", "datasets.{test_set}"),
        megabytes=4_000,
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
        stereo_steps.complete(),
        _airlight(),
        _fog(),
        _fog_model(),
        stereo_steps.fog(),
        stereo_steps.complete_synscapes(),
        stereo_steps.fog_completed(),
        *(_subset(kind) for kind in KINDS),
        *_trainings(),
        *(_evaluate(row) for row in ROWS),
        _tables(),
        _tables_paper(),
        stereo_steps.tables_depth(),
        *(_figure(name) for name in FIGURES),
        _view(),
        measured_steps.stability(),
        measured_steps.atlas(),
        measured_steps.tradeoff_fog(),
        measured_steps.tradeoff_networks(),
        measured_steps.tradeoff_accuracy(),
    ]


def all_jobs(params: Params) -> list[Job]:
    """Every job that the params ask for, and those of steps that only a person asks for."""
    return [Job(step, params, values) for step in steps() for values in step.all_values(params)]


def of(word: str) -> list[Step]:
    """The kinds of jobs of a word."""
    return [step for step in steps() if step.word == word]


FREE = ("network", "seed", "test_set")
"""Wildcards that may have other values than the params list, in a job that a person runs by hand."""


def job(params: Params, name: str, **values: str) -> Job:
    """The job of a step, or of that step of a word which lists the values; raises UsageError if there is none."""
    known = [step for step in steps() if name in (step.name, step.word) and set(step.wildcards) == {*values}]
    wrong: dict[str, None] = {}
    for step in known:
        listed_here = {key: listed(params, step.wildcards[key]) for key in values if key not in FREE}
        if all(values[key] in names for key, names in listed_here.items()):
            return Job(step, params, values)
        for key, names in listed_here.items():
            if values[key] not in names:
                wrong[f"{step.wildcards[key]}, which has {', '.join(names) or 'nothing'}"] = None
    said = " ".join(f"--{key} {value}" for key, value in values.items() if key not in FREE)
    raise UsageError(f"{said or name}: not in {'; not in '.join(wrong) or 'the table of steps'}")


def code_file(step: Step, values: Values) -> str:
    """Where DVC finds the digest of the code of a job."""
    return "/".join([CODE, step.name, *(values[name] for name in step.code_wildcards())]) + ".txt"
