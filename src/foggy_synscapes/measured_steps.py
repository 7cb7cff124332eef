"""The part of the table of steps that measures: numbers at their extremes, and time against accuracy."""

from foggy_synscapes.datasets import test_settings
from foggy_synscapes.jobs import Each, Step, Values
from foggy_synscapes.params import Params
from foggy_synscapes.results import FOG, INDEX, RESULTS, RUN
from foggy_synscapes.step_files import NETWORK, SEED, files, sources

CAPS = ("images", "minutes")


def stability() -> Step:
    return Step(
        name="stability",
        word="stability",
        text="Check the numbers at the extremes of their inputs.",
        command="stability",
        outputs={
            **files(f"{RESULTS}/stability/stability", "csv", "tex", "md", "png", "pdf"),
            "record": f"{RESULTS}/stability/run.json",
        },
        params=("stability",),
        megabytes=2_000,
    )


def atlas() -> Step:
    made = f"{RESULTS}/atlas"
    return Step(
        name="atlas",
        word="atlas",
        text="Score the fog models against path tracing.",
        command="atlas",
        outputs={
            **files(f"{made}/atlas", "csv", "tex", "md", "png", "pdf"),
            **{name: f"{made}/{name}.csv" for name in ("bounds", "held", "enough", "fitted")},
            "record": f"{made}/run.json",
        },
        params=("atlas",),
        code=tuple(f"fog_models.{name}" for name in ("none", "homogeneous", "layered", "heterogeneous", "surround")),
        megabytes=2_000,
        default=False,
    )


def tradeoff_fog() -> Step:
    made = f"{RESULTS}/tradeoff/fog"
    keys = ("tradeoff.betas", "tradeoff.frames", "tradeoff.repeats", "scenes.roots.synscapes", "scenes.shards")
    return Step(
        name="tradeoff_fog",
        word="tradeoff",
        text="Measure ways of computing fog.",
        command="tradeoff --part fog",
        inputs=sources(["frames"]),
        outputs={**files(made, "csv", "tex", "md", "png", "pdf"), "record": f"{made}.run.json"},
        params=keys,
        megabytes=4_000,
        minutes=120,
        default=False,
    )


def all_shards(params: Params, _values: Values) -> list[str]:
    """Shards of all lists: training images are read too, to calibrate 8 bits and to time training."""
    return [f"{FOG}/beta_{beta}/{shard}.tar" for beta in params.fog.betas for shard in params.scenes.shards]


def tradeoff_networks() -> Step:
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
            "models": Each(f"{RESULTS}/train", f"{RUN}/model.safetensors", {**first, "row": (row,)}),
            "metrics": Each(
                f"{RESULTS}/evaluate",
                f"{{test_set}}/{RUN}/metrics.json",
                {**test_set, **first, "row": ("subset.pure",)},
            ),
        },
        outputs={
            **files(f"{made}/networks", "csv", "tex", "md", "png", "pdf"),
            **{f"training_{ending}": f"{made}/training.{ending}" for ending in ("csv", "tex")},
            "record": f"{made}/networks.run.json",
        },
        params=(*keys, "scenes.roots", *test_settings(), "subset.pure", "train"),
        code=(f"networks.*{NETWORK}", "datasets.*tradeoff.test_set"),
        waits=all_shards,
        megabytes=8_000,
        minutes=600,
        default=False,
    )


def tradeoff_accuracy() -> Step:
    made = f"{RESULTS}/tradeoff/accuracy"
    models = {"network": (NETWORK,), "row": ("tradeoff.row",), "seed": (f"{SEED}.0",)}
    return Step(
        name="tradeoff_accuracy",
        word="tradeoff",
        text="Score the trained networks on fog that is made in cheaper and rougher ways.",
        command="tradeoff --part accuracy",
        inputs={
            **sources(["frames"]),
            "models": Each(f"{RESULTS}/train", f"{RUN}/model.safetensors", models),
        },
        outputs={**files(made, "csv", "tex", "md"), "record": f"{made}.run.json"},
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
