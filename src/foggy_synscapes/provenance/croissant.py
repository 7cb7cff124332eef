"""A Croissant description of a foggy dataset that was made: its shards, their hashes, and how its records are read.

Format: Croissant 1.0, https://docs.mlcommons.org/croissant/docs/croissant-spec.html (Akhtar et al., 2024).
"""

import json
from pathlib import Path
from typing import Any

from foggy_synscapes import __version__
from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import STAND_IN, Params
from foggy_synscapes.provenance.runs import leaves, read_run, state

CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "equivalentProperty": "cr:equivalentProperty",
    "dct": "http://purl.org/dc/terms/",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""The JSON-LD context that the specification prescribes."""
PAPER = (
    "@inproceedings{hahner2019, title={Semantic Understanding of Foggy Scenes with Purely Synthetic Data}, "
    "author={Hahner, Martin and Dai, Dengxin and Sakaridis, Christos and Zaech, Jan-Nico and Van Gool, Luc}, "
    "booktitle={IEEE Intelligent Transportation Systems Conference (ITSC)}, year={2019}}"
)
LICENCE = "https://spdx.org/licenses/MIT.html"


def croissant(params: Params, folder: Path, date: str, place: Path) -> str:
    """The description of the shards in a folder such as results/fog/beta_0.005, as JSON.

    date : of publication, e.g. 2026-11-24; run records hold none
    place : folder that the description is for: paths in it are relative to it, so it is `folder` or one above

    Equal shards and dates give equal bytes. Raises FoggyError if there is no shard, or one is not what its run record
    says; UsageError if the shards do not lie below `place`.
    """
    records = {path: read_run(path) for path in sorted(folder.glob("*.run.json"))}
    shards = {Path(name): (record, digest) for record in records.values() for name, digest in record["outputs"].items()}
    shards = {path: made for path, made in shards.items() if path.suffix == ".tar"}
    if not shards:
        raise FoggyError(
            f"{folder}: no foggy images in shards. Name a folder such as results/fog/beta_0.005, made by fog."
        )
    for path, (_, digest) in shards.items():
        if (found := state(path, digest)) != "unchanged":
            raise FoggyError(
                f"{path}: {found}, so it is not described. Run the engine again; it makes anew what is missing."
            )
    if not folder.resolve().is_relative_to(place.resolve()):
        raise UsageError(f"--out in {place}: the description names shards by paths below it; {folder} is elsewhere")
    images = sum(len(read_csv(str(path.with_suffix(".csv")))) for path in shards)
    record = next(iter(shards.values()))[0]
    dataset = "cityscapes_stereo" if "--stereo" in record["command"] else "synscapes"
    beta = record["command"][record["command"].index("--beta") + 1]
    settings = ", ".join(f"{key} {value}" for key, value in leaves(record["params"]))
    stand_in = params.scenes.roots.get(dataset) == STAND_IN
    name = "foggy-synscapes" if dataset == "synscapes" else "foggy-cityscapes"
    of = "stand-in images, drawn in place of it" if stand_in else "it"
    document = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": f"{name}-beta-{beta}".replace(".", "-"),
        "description": (
            f"{images} foggy images of {DATASETS[dataset].title}, made of {of} with fog of beta {beta} 1/m by Foggy "
            f"Synscapes {__version__}. Settings: {settings}."
        ),
        "url": f"https://{DATASETS[dataset].home}",
        "license": LICENCE if stand_in else f"the terms of {DATASETS[dataset].title}, {DATASETS[dataset].home}",
        "creator": {"@type": "sc:Organization", "name": "Foggy Synscapes contributors"},
        "datePublished": date,
        "version": __version__,
        "citeAs": PAPER,
        "distribution": [
            *(_shard(place, path, digest) for path, (_, digest) in sorted(shards.items())),
            _images(shards),
        ],
        "recordSet": [_records()],
    }
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _shard(place: Path, path: Path, digest: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": f"shard-{path.stem}",
        "name": f"shard-{path.stem}",
        "description": "A shard: an uncompressed tar file of foggy images.",
        "contentUrl": path.resolve().relative_to(place.resolve()).as_posix(),
        "contentSize": f"{path.stat().st_size} B",
        "encodingFormat": "application/x-tar",
        "sha256": digest,
    }


def _images(shards: dict[Path, Any]) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": "images",
        "name": "images",
        "description": "All foggy images, 8-bit RGB PNG.",
        "containedIn": [{"@id": f"shard-{path.stem}"} for path in sorted(shards)],
        "encodingFormat": "image/png",
        "includes": "*.png",
    }


def _records() -> dict[str, Any]:
    def field(name: str, text: str, kind: str, extract: str) -> dict[str, Any]:
        return {
            "@type": "cr:Field",
            "@id": f"foggy/{name}",
            "name": f"foggy/{name}",
            "description": text,
            "dataType": kind,
            "source": {"fileSet": {"@id": "images"}, "extract": {"fileProperty": extract}},
        }

    return {
        "@type": "cr:RecordSet",
        "@id": "foggy",
        "name": "foggy",
        "description": "One record for each foggy image.",
        "field": [
            field("name", "File name: number or name of the frame, and beta.", "sc:Text", "filename"),
            field("image", "The foggy image.", "sc:ImageObject", "content"),
        ],
    }
