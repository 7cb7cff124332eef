"""The lineage of a result as a Workflow Run RO-Crate: files, jobs as actions, params, versions, in one folder or ZIP.

Profile: https://w3id.org/ro/wfrun/workflow/0.5 (Leo et al., Recording provenance of workflow runs with RO-Crate, 2024).
The same results and date give the same bytes.
"""

import json
import tempfile
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from foggy_synscapes import __version__
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.lineage import UNCHANGED, Lineage
from foggy_synscapes.provenance.runs import leaves

if TYPE_CHECKING:
    from rocrate.model.entity import Entity
    from rocrate.rocrate import ROCrate

PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
WORKFLOW = "Snakefile"
LARGEST = 10_000_000
"""Bytes above which a file is described by its hash and not copied."""
LICENSE = "https://spdx.org/licenses/MIT"


def write_crate(lineage: Lineage, name: str, target: Path, date: str) -> int:
    """Write the crate of a result to a new folder, or to a ZIP if `target` ends so; returns how many jobs it tells of.

    `date` is the crate's date of publication, e.g. 2026-11-24: records hold no time.

    Raises
    ------
    FoggyError
        If the target exists, a file is not as recorded, or the package rocrate is missing.
    """
    if target.exists():
        raise FoggyError(f"--crate {target}: exists. Choose another name, or remove it.")
    crate, jobs = _described(lineage, name, date)
    if target.suffix != ".zip":
        crate.write(target)
        return jobs
    with tempfile.TemporaryDirectory() as folder:
        crate.write(folder)
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(path for path in Path(folder).rglob("*") if path.is_file()):
                # A ZIP entry made by name has the same time and rights on every machine.
                entry = zipfile.ZipInfo(path.relative_to(folder).as_posix())
                archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return jobs


def _described(lineage: Lineage, name: str, date: str) -> tuple["ROCrate", int]:
    try:
        from rocrate.model.contextentity import ContextEntity
        from rocrate.rocrate import ROCrate
    except ImportError as error:
        raise FoggyError("--crate needs the package rocrate: pip install 'foggy-synscapes[crate]'") from error

    crate = ROCrate(version="1.1")

    def add(own_id: str, kind: str, **properties: Any) -> "Entity":
        known = crate.get(own_id)
        return known or crate.add(ContextEntity(crate, own_id, properties={"@type": kind, **properties}))

    crate.name = f"{name} and what it was made from"
    crate.description = "Files, jobs, params and versions behind one result of the project foggy-synscapes."
    crate.datePublished = date
    crate.license = add(LICENSE, "CreativeWork", name="MIT License")
    crate.root_dataset["conformsTo"] = [
        add(url, "CreativeWork", name=title, version=version) for url, (title, version) in PROFILES.items()
    ]
    workflow = crate.add_workflow(WORKFLOW, WORKFLOW, main=True, lang="snakemake")
    workflow["name"], workflow["version"] = "foggy-synscapes", __version__
    files = _Files(crate, lineage, add)
    places = lineage.jobs(name)
    actions, raw = [], []
    for place in places:
        record = lineage.records[place]
        word = record["command"][1]
        code = source_digest.identity(record["code"])
        libraries = [
            add(f"#{library}-{version}", "SoftwareApplication", name=library, softwareVersion=version)
            for library, version in sorted(record["versions"].items())
        ]
        tool = add(
            f"#foggy-{word}-{code[:12]}",
            "SoftwareApplication",
            name=f"foggy {word}",
            softwareVersion=__version__,
            identifier=f"sha256:{code}",
            softwareRequirements=libraries,
        )
        values = [
            add(
                f"#{sha256_bytes(f'{key}={_plain(value)}'.encode())[:16]}",
                "PropertyValue",
                name=key,
                value=_plain(value),
            )
            for key, value in [*leaves(record["params"]), *leaves(record["instructions"], "instructions.")]
        ]
        if not record["inputs"]:
            raw += [files.entity(output) for output in record["outputs"]]
        action = add(
            f"#{place.as_posix()}",
            "CreateAction",
            name=" ".join(record["command"]),
            instrument=tool,
            object=[*(files.entity(file, digest) for file, digest in record["inputs"].items()), *values],
            result=[files.entity(output) for output in record["outputs"]],
            subjectOf=files.plain(place),
        )
        actions.append(action)
    whole = add(
        "#run",
        "CreateAction",
        name=f"run of the workflow for {name}",
        instrument=workflow,
        object=raw,
        result=[files.entity(name)],
    )
    crate.root_dataset["mentions"] = [whole, *actions]
    return crate, len(places)


class _Files:
    """Entities of files: small ones are copied into the crate, large ones and those elsewhere described by hashes."""

    def __init__(self, crate: "ROCrate", lineage: Lineage, add: Any) -> None:
        self.crate, self.lineage, self.add = crate, lineage, add

    def entity(self, name: str, digest: str | None = None) -> "Entity":
        node = self.lineage.file(name, digest)
        if node["state"] != UNCHANGED:
            raise FoggyError(
                f"{name}: {node['state']}; a crate tells of what is as recorded. Run foggy trace, then make it again."
            )
        size = Path(name).stat().st_size
        about = {"sha256": node["sha256"], "contentSize": str(size)}
        if name in self.lineage.makers and size <= LARGEST:
            return self._file(name, about)
        return self.add(f"#sha256-{node['sha256']}", "CreativeWork", name=Path(name).name, **about)

    def plain(self, path: Path) -> "Entity":
        """A file as it is: a run record."""
        return self._file(path.as_posix(), {"about": {"@id": f"#{path.as_posix()}"}})

    def _file(self, name: str, properties: dict[str, Any]) -> "Entity":
        return self.crate.get(name) or self.crate.add_file(
            name, name, properties={"name": Path(name).name, **properties}
        )


def _plain(value: Any) -> Any:
    return value if isinstance(value, str | int | float | bool) else json.dumps(value, sort_keys=True)
