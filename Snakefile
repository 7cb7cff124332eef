"""The experiment, from raw data to tables: `snakemake --cores 2`.

What is run is in params.yaml (or in the file given by --configfile); what each step reads and writes is in the table of
steps, src/foggy_synscapes/steps.py, from which workflow/rules, one file per word, take it. Every rule is one `foggy`
line that can be pasted into a shell.
"""

import json
import os
import sys
from functools import cache
from pathlib import Path
from shlex import join, quote

from snakemake.utils import min_version

from foggy_synscapes import params as parameters
from foggy_synscapes import results
from foggy_synscapes import steps as table
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import remove_leftovers
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.reasons import reasons
from foggy_synscapes.jobs import Job, at
from foggy_synscapes.planning import asked
from foggy_synscapes.provenance.current import (
    changed_raw_data,
    out_of_date,
    raw_data_in_words,
)
from foggy_synscapes.provenance.runs import PLANNED, params_digest, select

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
        raise FoggyError(f"--configfile: give one params file, got {' '.join(files)}")
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
for warning in PARAMS.warnings():
    print(f"{PARAMS_FILE}: warning: {warning}", file=sys.stderr)

# Commands read params.yaml unless told otherwise; so both engines run the same line on the same file.
PARAMS_OPTION = (
    "" if PARAMS_FILE == "params.yaml" else f" --params {quote(PARAMS_FILE)}"
)
VALUES = PARAMS.model_dump(mode="json", by_alias=True)
NAMED = 5  # jobs out of date that are named


def check_raw_data():
    """Refuse to plan on an index that its files have left behind: results would stay as they were, and be stale."""
    for step in steps("scenes"):
        job = Job(step, PARAMS, {})
        changed = changed_raw_data(job)
        if changed:
            raise WorkflowError(raw_data_in_words(job, changed, PARAMS_OPTION))


@cache
def plan():
    """Have the jobs run whose records are not of today's code, params and files: Snakemake itself knows times alone.

    Called when Snakemake asks for the files of the first job: not before has it a graph to be told of. Returns the
    commands of the jobs that run, and the files of those that come out as they were recorded.
    """
    if not IS_PLANNED_HERE:
        return set(), set()
    dag = workflow.dag
    rules = {rule.name for rule in dag.forcerules}
    forced = {step.name for step in table.steps() if rules & {step.rule, step.word}}
    forced |= {*map(str, dag.forcefiles)}
    found = out_of_date(PARAMS, forced, asked.outputs(PARAMS, "all"))
    again = [each for each in found if each.node.is_there]
    dag.forcefiles.update(path for each in again for path in each.node.written)
    for each in again[:NAMED]:
        print(f"out of date: {each.node.name}: {each.why}", file=sys.stderr)
    if len(again) > NAMED:
        print(f"out of date: {len(again) - NAMED} more", file=sys.stderr)
    alone = {path for each in found if each.alone for path in each.node.written}
    return {each.node.name for each in found}, alone


def known(step, paths, wildcards):
    """Input files of a job, flagged so that Snakemake does as `plan` says.

    Of a job that is up to date times do not count, and it does not wait for an input that comes out as it was.
    """
    planned, alone = plan()
    if join(Job(step, PARAMS, dict(wildcards.items())).command) in planned:
        return paths
    return [ancient(path) for path in paths if path not in alone]


def steps(word):
    """Kinds of jobs of a word that these params ask for."""
    return [step for step in table.of(word) if step.all_values(PARAMS)]


def inputs(step):
    """Files that a job reads."""
    return lambda wildcards: known(
        step, step.all_inputs(PARAMS, dict(wildcards.items())), wildcards
    )


def waits(step):
    """Files that a job waits for, whose content its other inputs vouch for."""

    def listed(wildcards):
        found = step.waits(PARAMS, dict(wildcards.items())) if step.waits else []
        return [ancient(path) for path in known(step, found, wildcards)]

    return listed


def asked_for(wildcards):
    """The results of the whole experiment, and what somebody altered of those before them."""
    return asked.outputs(PARAMS, "all") + sorted(plan()[1])


def outputs(step, **shown):
    """Files that a job writes; those of the names in `shown` are in the report, with its caption and category."""
    flag, files = report, []
    for name, template in step.outputs.items():
        paths = step.templates(template, PARAMS)
        files += [
            flag(path, **shown[name]) if name in shown else path for path in paths
        ]
    return files


def place(folder, step, ending):
    """Where a job's log or benchmark is."""
    values = "_".join(f"{{{name}}}" for name in step.wildcards)
    return f"{folder}/{step.name}{'/' if values else ''}{values}.{ending}"


def log_file(step):
    return place(results.LOGS, step, "log")


def benchmark_file(step):
    return place(results.BENCHMARKS, step, "tsv")


def constraints(step):
    """Values that the wildcards of a rule may have and no others."""
    lists = {name: set() for name in step.wildcards}
    for values in step.all_values(PARAMS):
        for name, value in values.items():
            lists[name].add(value.replace(".", r"\."))
    return {name: "|".join(sorted(values)) for name, values in lists.items()}


def reads(step):
    """Values of params that a job reads, as Snakemake's own record of it keeps them.

    A function of the wildcards, because Snakemake would fill in what is in braces in a text, such as a folder.
    """
    return lambda wildcards: json.dumps(
        select(VALUES, *Job(step, PARAMS, dict(wildcards.items())).keys()),
        sort_keys=True,
    )


def memory(step):
    """What a job asks of a cluster, in MB; where that was not enough, the next attempt asks for as much again."""
    return lambda wildcards, attempt: attempt * step.megabytes


def threads_of(step):
    return at(PARAMS, step.threads) if step.threads else 1


def gpus(step):
    return 1 if step.gpu and PARAMS.device_of(step.word) != "cpu" else 0


def command(step):
    """The command of a job with its params file, to which its rule adds the log."""
    return lambda wildcards: (
        join(Job(step, PARAMS, dict(wildcards.items())).command) + PARAMS_OPTION
    )


# What the terminal says of a job that starts: its command. Where --printshellcmds asks for all of it, Snakemake's own text.
MESSAGE = None if workflow.output_settings.printshellcmds else "{params.command}"

# Jobs know by this that the lock of this folder is held for them, and with which params they were planned.
os.environ[lock.HELD] = "snakemake"
LOCKS = []

# Another run that is under way may be drawing right now; this one will then be refused for its lock.
IS_PLANNED_HERE = workflow.is_main_process and lock.is_free()
if workflow.is_main_process:
    os.environ[PLANNED] = params_digest(PARAMS)
if IS_PLANNED_HERE:
    check_raw_data()


onstart:
    try:
        LOCKS.append(lock.hold(against_dvc=True))
    except FoggyError as error:
        raise WorkflowError(str(error))
    remove_leftovers(results.RESULTS)


onerror:
    # Snakemake says of a failed job which command it was, and the reason is in its log.
    for reason in reasons(log):
        print(reason, file=sys.stderr)


rule all:
    """The tables, the figures and the check of the numbers at their extremes."""
    default_target: True
    input:
        asked_for,


rule paper:
    """The rows of the paper's two tables and nothing that they do not need: `snakemake --cores 2 paper`."""
    input:
        asked.outputs(PARAMS, "paper"),


# Each word is a target: `snakemake --cores 2 fog` makes all results of this step, and what they need.
for word in dict.fromkeys(step.word for step in table.steps()):
    if word not in {step.rule for step in steps(word)} and asked.outputs(PARAMS, word):

        rule:
            """All results of one word."""
            name:
                word
            input:
                asked.outputs(PARAMS, word),


include: "workflow/rules/scenes.smk"
include: "workflow/rules/filter.smk"
include: "workflow/rules/complete.smk"
include: "workflow/rules/fog.smk"
include: "workflow/rules/subset.smk"
include: "workflow/rules/train.smk"
include: "workflow/rules/evaluate.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/view.smk"
include: "workflow/rules/stability.smk"
include: "workflow/rules/atlas.smk"
include: "workflow/rules/tradeoff.smk"
