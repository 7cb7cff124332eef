"""The params section `complete`: fog on Cityscapes made here, from stereo."""

from typing import Literal

from pydantic import model_validator

from foggy_synscapes.schema import Beta, Section, setting


class Complete(Section):
    """Depth completed from stereo, and the fog that is made of it; without this section there is none."""

    shard_frames: int = setting("of the stereo frames, sorted by name, in a shard", unit="frames", ge=1)
    shards: list[str] = setting(
        "of the stereo frames, numbered from 0000: shard_frames each, to the last frame", min_length=1
    )
    betas: list[Beta] = setting(
        "attenuation coefficients of the fog that is made, quoted", unit="1/m", published='["0.005", "0.01", "0.02"]'
    )
    refine: Literal["guided", "bilateral"] = setting(
        "transmittance by the guided filter (SFSU) or by the dual-reference cross-bilateral filter (DBF)",
        published="guided",
        source="IJCV 2018, section 3.2; ECCV 2018, section 3",
    )
    superpixels: int = setting(
        "wanted in an image; each needs 20 reliable pixels", ge=1, published="2048", source="IJCV 2018, section 3.1"
    )
    seed: int = setting(
        "of the random permutations, the same for each image", ge=0, lt=2**32, published="5489", source="their code"
    )

    @model_validator(mode="after")
    def _in_order(self) -> "Complete":
        expected = [f"{number:04d}" for number in range(len(self.shards))]
        if self.shards != expected:
            raise ValueError(f"shards: expected the names {expected[0]} to {expected[-1]} in order, got {self.shards}")
        if len(set(self.betas)) != len(self.betas):
            raise ValueError(f"betas: each once, got {self.betas}")
        return self
