"""Names of images and label maps in the lists of `subset`, independent of where a machine keeps its data.

`cityscapes:gtFine/val/...png` lies below that dataset's root; `fog:beta_0.005/0000.tar#00001_beta_0.005.png` is a
member of a shard of fog.
"""

from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import checked, read_checked
from foggy_synscapes.io.shards import Shard

RECIPE = ".json"
MADE = "cityscapes"
"""Folder of shards of Foggy Cityscapes made here, below that of fog."""
COMPLETED = "completed"
"""Folder of shards of Foggy Synscapes of completed depth, below that of fog."""
OPEN_SHARDS = 64
"""Shards held open at once; 50 hold the whole of Synscapes at one beta."""


def of_dataset(dataset: str, path: str) -> str:
    """URI of a file of a dataset."""
    return f"{dataset}:{path}"


def of_fog(beta: str, shard: str, member: str, model: str = "") -> str:
    """URI of a foggy image in a shard; `model` : of fog, where it is not that of all other rows."""
    return f"fog:{f'{model}/' if model else ''}beta_{beta}/{shard}.tar#{member}"


def of_made(beta: str, shard: str, member: str) -> str:
    """URI of an image of Foggy Cityscapes made here."""
    return f"fog:{MADE}/beta_{beta}/{shard}.tar#{member}"


def of_completed(beta: str, shard: str, member: str) -> str:
    """URI of an image of Foggy Synscapes of completed depth."""
    return f"fog:{COMPLETED}/beta_{beta}/{shard}.tar#{member}"


def recipe(member: str) -> str:
    """Name of the member that says how to composite a foggy image, and stands in a shard in its place.

    >>> recipe("00001_beta_0.005.png")
    '00001_beta_0.005.json'
    """
    return member.removesuffix(".png") + RECIPE


class Reader:
    """Reads what URIs name, and checks it against the listed SHA-256.

    Parameters
    ----------
    roots : folder of each dataset
    fog : folder of the fog shards
    """

    def __init__(self, roots: Mapping[str, Path], fog: str | Path = "") -> None:
        self.roots, self.fog = dict(roots), Path(fog)
        self._shards: OrderedDict[str, Shard] = OrderedDict()

    def read(self, uri: str, sha256: str) -> bytes:
        """Bytes behind a URI.

        Raises
        ------
        FoggyError
            If the name is malformed or leads out of its folder, or the content is missing or not as listed.
        """
        scheme, separator, path = uri.partition(":")
        if not separator or path.startswith("/") or ".." in path.replace("#", "/").split("/"):
            raise FoggyError(f"{uri!r}: not the name of an image; expected DATASET:PATH or fog:SHARD#MEMBER")
        if scheme == "fog":
            shard, _, member = path.partition("#")
            return checked(self._shard(shard).read(member), sha256, uri)
        if scheme not in self.roots:
            raise FoggyError(f"{uri!r}: no dataset {scheme!r}; known are {', '.join(sorted(self.roots))} and fog")
        return read_checked(self.roots[scheme] / path, sha256)

    def _shard(self, name: str) -> Shard:
        if name not in self._shards:
            self._shards[name] = Shard(self.fog / name)
            if len(self._shards) > OPEN_SHARDS:
                self._shards.popitem(last=False)[1].close()
        self._shards.move_to_end(name)
        return self._shards[name]

    def __getstate__(self) -> dict:
        # Open files do not travel to loader processes; each opens its own.
        return {"roots": self.roots, "fog": self.fog, "_shards": OrderedDict()}
