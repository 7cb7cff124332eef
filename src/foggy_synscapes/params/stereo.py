"""The params section `stereo`: Foggy Synscapes of depth that a simulated stereo camera measured."""

from foggy_synscapes.depth.simulation import Errors
from foggy_synscapes.schema import Section, setting


class StereoErrors(Section):
    """What the stereo camera does wrong before scenes whose depth is known; without this section there is none."""

    baseline: float = setting("between both views", unit="m", gt=0, source="Cityscapes' camera files: 0.209313")
    noise: float = setting(
        "standard deviation of the disparity, at 2048 columns", unit="pixels", ge=0, source="as in the stand-in: 0.35"
    )
    step: float = setting("to which disparity is rounded, at 2048 columns", unit="pixels", gt=0)
    least: float = setting("disparity that is found, at 2048 columns; smaller is a hole", unit="pixels", ge=0)
    levels: float = setting("standard deviation of the right view's own noise", unit="levels of 8 bits", ge=0)
    superpixels: int = setting(
        "wanted in an image; each needs 20 reliable pixels", ge=1, published="2048", source="IJCV 2018, section 3.1"
    )
    seed: int = setting("of the noise; a frame's own number is added", ge=0)

    def errors(self) -> Errors:
        """What the simulation takes."""
        return Errors(self.baseline, self.noise, self.step, self.least, self.levels)
