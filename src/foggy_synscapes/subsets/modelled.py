"""Lists of Foggy Synscapes images by a fog model of the row's own: purely synthetic."""

from foggy_synscapes.datasets import uris
from foggy_synscapes.subsets import pure
from foggy_synscapes.subsets.kind import MODELLED, Kind, Lists, ModelledRow, Sources


def lists(sources: Sources, entry: ModelledRow, key: str) -> Lists:
    """The same frames as those of `pure`, in other fog."""

    def uri(beta: str, shard: str, name: str) -> str:
        return uris.of_fog(beta, shard, name, entry.model)

    return pure.listed(sources, entry, key, sources.foggy(MODELLED), uri)


KIND = Kind(
    text="lists of Foggy Synscapes by a fog model of the row's own: purely synthetic",
    order=5,
    entry=ModelledRow,
    reads=("synscapes", MODELLED),
    lists=lists,
    keys=("scenes.shards",),
)
