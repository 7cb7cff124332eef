"""What a figure declares: what it shows, what it is drawn from, and how."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources
else:
    Drawing = Sources = Any  # names for the signatures of figures, which import neither to be declared

FRAMES = "frames"
"""The kept frames of Synscapes: its indexes and the filter's list."""
REFINED = "refined"
"""The refined images of Foggy Cityscapes: its index and that of Cityscapes."""
FILTER = "filter"
"""What the filter found in each frame: its table of all frames."""
CURVES = "curves"
"""The losses of every training: curves.csv."""
METRICS = "metrics"
"""The scores of every model on the figure's test set: metrics.json."""
PREDICTIONS = "predictions"
"""The predictions of every model on the figure's test set: predictions.tar."""
IMAGES = "images"
"""Images and label maps of the figure's test set: its index."""

INPUTS = (FRAMES, REFINED, FILTER, CURVES, METRICS, PREDICTIONS, IMAGES)
"""What `Figure.inputs` may name. Sources has a method for each."""
OF_TEST_SET = (METRICS, PREDICTIONS, IMAGES)
"""Those that there are for each test set."""

RUNS = ("train.networks", "train.seeds", "train.from_weights", "train.from_baseline", "tables.rows")
"""Keys of which runs there are, and in which order they are shown: of each figure of runs."""


@dataclass(frozen=True)
class Figure:
    """A figure.

    text : what it shows, in a line
    inputs : what it is drawn from, out of INPUTS
    draw : from sources to a figure of matplotlib; FoggyError where what it shows is missing, damaged or not as
        listed
    keys : dotted keys of the params that it is drawn by, beside the section `figures`
    of_test_set : whether there is one for each test set, which is then named NAME_TESTSET
    asked : a key of the params without which there is no such figure
    """

    text: str
    inputs: tuple[str, ...]
    draw: Callable[[Sources], Drawing]
    keys: tuple[str, ...] = ()
    of_test_set: bool = False
    asked: str = ""

    def __post_init__(self) -> None:
        unknown = [name for name in self.inputs if name not in INPUTS]
        if unknown:
            raise ValueError(f"inputs: {', '.join(unknown)} unknown; there are {', '.join(INPUTS)}")
        of_one = [name for name in self.inputs if name in OF_TEST_SET]
        if of_one and not self.of_test_set:
            raise ValueError(f"inputs: {', '.join(of_one)} of which test set? Declare of_test_set=True.")
