"""Lists of Foggy Synscapes images: purely synthetic."""

from collections.abc import Callable, Mapping

from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.subsets.kind import FOG, FoggyRow, Kind, Lists, Sources


def lists(sources: Sources, entry: FoggyRow, key: str) -> Lists:
    """The first kept frames for training, the last for validation (paper, sections IV.A and IV.B)."""
    return listed(sources, entry, key, sources.foggy(), uris.of_fog)


def listed(
    sources: Sources,
    entry: FoggyRow,
    key: str,
    members: Mapping[str, tuple[str, str]],
    uri: Callable[[str, str, str], str],
) -> Lists:
    """The lists of `lists`, of any foggy images of Synscapes.

    members : shard and SHA-256 of each image by name; uri : of beta, shard and name
    """
    index, kept = sources.index("synscapes"), sources.kept()
    asked = entry.train + entry.validation
    if asked > len(kept):
        raise FoggyError(
            f"{key}: asks for {entry.train} training and {entry.validation} validation frames, but the filter kept "
            f"{len(kept)}. Ask for fewer, loosen filter.rules, or add frames."
        )
    result = []
    for frames in (kept[: entry.train], kept[len(kept) - entry.validation :]):
        lines = []
        for frame in frames:
            name = synscapes.foggy_name(frame, entry.beta)
            name = name if name in members else uris.recipe(name)
            if name not in members:
                raise FoggyError(
                    f"beta {entry.beta}: no shard holds frame {frame}. Was it dropped for its blue "
                    "airlight? Then ask for fewer frames, or set fog.blue_airlight to keep or grey."
                )
            label = synscapes.class_(frame)
            expect(index, [label], "synscapes")
            shard, digest = members[name]
            lines.append((uri(entry.beta, shard, name), digest, uris.of_dataset("synscapes", label), index[label]))
        result.append(lines)
    return result[0], result[1]


KIND = Kind(
    text="lists of Foggy Synscapes: purely synthetic",
    order=2,
    entry=FoggyRow,
    reads=("synscapes", FOG),
    lists=lists,
    keys=("scenes.shards",),
)
