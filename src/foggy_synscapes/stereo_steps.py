"""The part of the table of steps that makes fog on Cityscapes from stereo; asked for by the section `complete`."""

from foggy_synscapes.datasets.uris import COMPLETED, MADE
from foggy_synscapes.jobs import Each, Step, Template, Values
from foggy_synscapes.params import Params
from foggy_synscapes.results import COMPLETE, FOG, KEPT, RESULTS, index

STEREO = "cityscapes_stereo"
COMPLETED_SHARDS = f"{FOG}/{COMPLETED}/beta_{{row.beta}}"
MADE_SHARDS = f"{FOG}/{MADE}/beta_{{row.beta}}"
"""Where the shards of a list's images are."""
DEPTH = {"depth": "depth.tar", "airlight": "airlight.csv"}
ENTRY = ("layouts.cityscapes",)


def made_images() -> dict[str, Template]:
    """What lists of these images are made of."""
    return {"made": Each(MADE_SHARDS, "{shard}.csv", {"shard": ("complete.shards",)})}


def made_shards(params: Params, values: Values) -> list[str]:
    """Shards that hold images of a row's list, which has the hash of each image."""
    entry, made = params.subset.made_here().get(values["row"]), params.complete
    return [f"{FOG}/{MADE}/beta_{entry.beta}/{shard}.tar" for shard in made.shards] if entry and made else []


def completed_images() -> dict[str, Template]:
    """What lists of images of completed depth are made of."""
    return {"completed": Each(COMPLETED_SHARDS, "{shard}.csv", {"shard": ("scenes.shards",)})}


def completed_shards(params: Params, values: Values) -> list[str]:
    """Shards that hold images of a row's list, which has the hash of each image."""
    entry = params.subset.of_completed_depth().get(values["row"])
    return [f"{FOG}/{COMPLETED}/beta_{entry.beta}/{shard}.tar" for shard in params.scenes.shards] if entry else []


def complete() -> Step:
    """Depth of a shard's frames, and their airlight."""
    shard = f"{COMPLETE}/{{shard}}"
    return Step(
        name="complete",
        word="complete",
        text="Complete the depth of a shard of stereo frames, and estimate their airlight.",
        command="complete --shard {shard}",
        wildcards={"shard": "complete.shards"},
        inputs={"index": index(STEREO)},
        outputs={
            "shard": f"{shard}/{DEPTH['depth']}",
            "manifest": f"{shard}/depth.csv",
            "airlight": f"{shard}/{DEPTH['airlight']}",
            "record": f"{shard}/run.json",
        },
        params=tuple(f"complete.{key}" for key in ("shard_frames", "shards", "superpixels", "seed")),
        asked="complete",
        code=ENTRY,
        minutes=120,
    )


def fog() -> Step:
    """Foggy images of a shard's frames at one beta."""
    images = f"{FOG}/{MADE}/beta_{{beta}}/{{stereo}}"
    return Step(
        name="fog_made",
        word="fog",
        text="Make the foggy images of one shard of stereo frames at one beta.",
        command="fog --beta {beta} --stereo {stereo}",
        wildcards={"beta": "complete.betas", "stereo": "complete.shards"},
        inputs={"index": index(STEREO), **{name: f"{COMPLETE}/{{stereo}}/{file}" for name, file in DEPTH.items()}},
        outputs={"shard": f"{images}.tar", "manifest": f"{images}.csv", "record": f"{images}.run.json"},
        params=("complete.refine", "fog.geometry", "fog.png_level"),
        asked="complete",
        code=ENTRY,
        minutes=120,
    )


FRAME_KEYS = ("fog.frames", "scenes.shard_frames")


def complete_synscapes() -> Step:
    """Depth of Synscapes as a simulated stereo camera would have it."""
    shard = f"{COMPLETE}/synscapes/{{shard}}"
    return Step(
        name="complete_synscapes",
        word="complete",
        text="Complete the depth of a shard of Synscapes from what a simulated stereo camera measures.",
        command="complete --synscapes-shard {shard}",
        wildcards={"shard": "scenes.shards"},
        inputs={"index": index("synscapes", "{shard}"), "kept": KEPT},
        outputs={"shard": f"{shard}/depth.tar", "manifest": f"{shard}/depth.csv", "record": f"{shard}/run.json"},
        params=(*FRAME_KEYS, "stereo"),
        asked="stereo",
        minutes=120,
    )


def fog_completed() -> Step:
    """Fog on Synscapes by that depth, and how far it is from fog by the true one."""
    images = f"{FOG}/{COMPLETED}/beta_{{beta}}/{{completed}}"
    return Step(
        name="fog_completed",
        word="fog",
        text="Make the foggy images of a shard of Synscapes at one beta, of completed depth, and measure errors.",
        command="fog --beta {beta} --completed {completed}",
        wildcards={"beta": "fog.betas", "completed": "scenes.shards"},
        inputs={
            "index": index("synscapes", "{completed}"),
            "kept": KEPT,
            "airlight": f"{FOG}/airlight/{{completed}}.csv",
            "depth": f"{COMPLETE}/synscapes/{{completed}}/depth.tar",
        },
        outputs={
            "shard": f"{images}.tar",
            "manifest": f"{images}.csv",
            "errors": f"{images}.errors",
            "record": f"{images}.run.json",
        },
        params=(*FRAME_KEYS, "fog.geometry", "fog.png_level"),
        asked="stereo",
        minutes=120,
    )


def tables_depth() -> Step:
    """The errors of all shards."""
    table = f"{RESULTS}/tables/depth_quality"
    return Step(
        name="tables_depth",
        word="tables",
        text="Print the errors of completed depth, and of the fog that is made of it, by class and distance.",
        command="tables --depth",
        inputs={
            "errors": Each(
                f"{FOG}/{COMPLETED}",
                "beta_{beta}/{shard}.errors",
                {"beta": ("fog.betas",), "shard": ("scenes.shards",)},
            )
        },
        outputs={"csv": f"{table}.csv", "md": f"{table}.md", "record": f"{table}.run.json"},
        params=("fog.betas", "scenes.shards", "scenes.roots"),
        asked="stereo",
    )
