"""The part of the table of steps that makes fog on Cityscapes from stereo; asked for by the section `complete`."""

from foggy_synscapes.datasets.uris import MADE
from foggy_synscapes.jobs import Each, Step, Template, Values
from foggy_synscapes.params import Params
from foggy_synscapes.results import COMPLETE, FOG, index

STEREO = "cityscapes_stereo"
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
