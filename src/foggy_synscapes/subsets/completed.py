"""Lists of Foggy Synscapes whose depth was measured by a simulated stereo camera and completed: what depth costs."""

from foggy_synscapes.datasets import uris
from foggy_synscapes.subsets import pure
from foggy_synscapes.subsets.kind import COMPLETED, FoggyRow, Kind, Lists, Sources


def lists(sources: Sources, entry: FoggyRow, key: str) -> Lists:
    """The same frames as those of `pure`."""
    return pure.listed(sources, entry, key, sources.foggy(COMPLETED), uris.of_completed)


KIND = Kind(
    text="lists of Foggy Synscapes of completed depth: what the quality of depth costs",
    order=4,
    entry=FoggyRow,
    reads=("synscapes", COMPLETED),
    lists=lists,
    keys=("scenes.shards",),
)
