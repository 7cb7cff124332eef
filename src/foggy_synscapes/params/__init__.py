"""The experiment's parameters: read from YAML, laid on the packaged defaults, checked, typed and frozen.

What is possible at all, and the meaning, unit and source of each value, stand in the sections' modules here; the values
in `defaults.yaml`; what a params file states is an overlay on them, see `reading`.
"""

from foggy_synscapes.datasets.dataset import STAND_IN
from foggy_synscapes.params.experiment import Params
from foggy_synscapes.params.fog import Fog
from foggy_synscapes.params.reading import check, load, require_complete
from foggy_synscapes.params.scenes import FilterRule
from foggy_synscapes.params.training import BASELINE

__all__ = ["BASELINE", "STAND_IN", "FilterRule", "Fog", "Params", "check", "load", "require_complete"]
