"""The experiment, from raw data to tables: `snakemake --cores 2`.

What is run stands in params.yaml (or in the file given by --configfile); how each step is wired stands in
workflow/rules, one file per word. Every rule is one `foggy` line that can be pasted into a shell.
"""

import json
import os
import sys
from pathlib import Path
from shlex import quote

from snakemake.utils import min_version

from foggy_synscapes.provenance import source_digest
from foggy_synscapes import params as parameters
from foggy_synscapes.datasets.index import changed_since_listed
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import remove_leftovers
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.provenance.check import stale_results
from foggy_synscapes.provenance.recorded import select

min_version("9.27")


report: "workflow/report/experiment.rst"


# The command `foggy` of the environment that runs this Snakemake.
os.environ["PATH"] = os.pathsep.join(
    [str(Path(sys.executable).parent), os.environ["PATH"]]
)


def params_file():
    """The one params file; values on the command line would not reach the commands, so they are refused."""
    files = [
        os.path.relpath(path) for path in workflow.config_settings.configfiles
    ] or ["params.yaml"]
    if len(files) > 1:
        raise FoggyError(
            f"--configfile: give one complete params file, got {' '.join(files)}"
        )
    if config and config != read_yaml(files[0]):
        raise FoggyError(
            "--config: write the values into a params file and give it by --configfile"
        )
    return files[0]


try:
    PARAMS_FILE = params_file()
    PARAMS = parameters.load(PARAMS_FILE)
except FoggyError as error:
    raise WorkflowError(str(error))

# Commands read params.yaml unless told otherwise; so both engines run the same line on the same file.
PARAMS_OPTION = (
    "" if PARAMS_FILE == "params.yaml" else f" --params {quote(PARAMS_FILE)}"
)
SHARDS = PARAMS.scenes.shards
VERSIONS = read_yaml("workflow/versions.yaml")
ROWS = [*PARAMS.train.from_weights, *PARAMS.train.from_baseline]


def check_raw_data():
    """Refuse to plan on an index that its files have left behind: results would stay as they were, and be stale."""
    for dataset, folder in PARAMS.scenes.roots.model_dump().items():
        for part in SHARDS if dataset == "synscapes" else ["all"]:
            changed = changed_since_listed(
                f"{dataset}/{part}", parameters.root(PARAMS, dataset)
            )
            if changed:
                raise WorkflowError(
                    f"{parameters.root(PARAMS, dataset)}: {len(changed)} files are not as they were listed, first "
                    f"{changed[0]}. Run `foggy scenes --dataset {dataset}{PARAMS_OPTION}`, then this again: only "
                    "what the change reaches is made anew."
                )


def check_makers():
    """Refuse to plan on results that others made with other params: Snakemake would take them for up to date."""
    stale = stale_results(PARAMS)
    if stale:
        raise WorkflowError(
            f"{stale[0]}: made with other params than those of {PARAMS_FILE}, by DVC or by hand, so that Snakemake "
            f"does not know it ({len(stale)} such files). Run `make repro` where DVC made it, then `foggy adopt "
            "--from dvc`; else delete the results of this step and of those that follow, then run this again."
        )


def code(word):
    """Source files that a command runs: an edit there re-runs its jobs."""
    return [f"src/foggy_synscapes/{name}" for name in source_digest.sources(word)]


def versions(word):
    """Versions of the libraries that a command computes with: another one re-runs its jobs."""
    return " ".join(f"{name}=={version}" for name, version in VERSIONS[word].items())


def reads(*keys):
    """Values of params that a command reads, by dotted key as in dvc.yaml: a change there re-runs its jobs.

    A function of the wildcards, because Snakemake would fill in what stands in braces in a text, such as a folder.
    """
    values = PARAMS.model_dump(mode="json", by_alias=True)
    text = json.dumps(select(values, *keys), sort_keys=True)
    return lambda wildcards: text


def one_of(names):
    """Wildcard constraint: one of these names and nothing else."""
    return "|".join(name.replace(".", r"\.") for name in names)


def memory(megabytes):
    """What a job asks of a cluster, in MB; where that was not enough, the next attempt asks for as much again."""
    return lambda wildcards, attempt: attempt * megabytes


# Jobs know by this that the lock of this folder is held for them.
os.environ[lock.HELD] = "snakemake"
LOCKS = []

# Another run that is under way may be drawing right now; this one will then be refused for its lock.
if workflow.is_main_process and lock.is_free():
    check_raw_data()
    check_makers()


onstart:
    try:
        LOCKS.append(lock.hold())
    except FoggyError as error:
        raise WorkflowError(str(error))
    remove_leftovers("results")


wildcard_constraints:
    dataset="cityscapes|foggy_cityscapes|foggy_driving|foggy_zurich|synscapes",
    shard=one_of(SHARDS),
    beta=one_of(PARAMS.fog.betas),
    row=one_of(ROWS),
    network=one_of(PARAMS.train.networks),
    seed=one_of(PARAMS.train.seeds),
    test_set=one_of(PARAMS.evaluate.test_sets),


TABLES = expand(
    "results/tables/{test_set}.{ending}",
    test_set=PARAMS.evaluate.test_sets,
    ending=["csv", "tex", "md", "html", "json"],
)
FIGURES = expand(
    "results/figures/{figure}.png",
    figure=["beta_strip", "fc_against_fs", "sky_contrast", "curves"],
) + expand(
    "results/figures/{kind}_{test_set}.png",
    kind=["predictions", "class_change", "confusion"],
    test_set=PARAMS.evaluate.test_sets,
)


rule all:
    """The tables, the figures and the check of the numbers at their extremes."""
    default_target: True
    input:
        TABLES,
        FIGURES,
        "results/stability/stability.csv",


include: "workflow/rules/scenes.smk"
include: "workflow/rules/filter.smk"
include: "workflow/rules/fog.smk"
include: "workflow/rules/subset.smk"
include: "workflow/rules/train.smk"
include: "workflow/rules/evaluate.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/stability.smk"
include: "workflow/rules/tradeoff.smk"
