"""A change makes run again what it reaches, and nothing else; every step reads what it declares, and nothing else."""

from pathlib import Path

import pytest
from changes import CHANGES
from engines import SMOKE, planned
from plans import compare_plans
from reads import undeclared, watch

# `make reruns` goes through the other changes of the table in tests/helpers/changes.py, `make reads` through all jobs.
RERUNS = ("a beta added, for FS-498", "a comment in the code of the fog", "a table altered by hand")
READS = ("filter", "subset FC-FS-498", "tables foggy_zurich")


@pytest.mark.parametrize("name", RERUNS)
def test_a_change_makes_exactly_the_jobs_run_that_it_reaches(snakemake: Path, dvc: Path, name: str) -> None:
    (change,) = (change for change in CHANGES if change.name == name)
    direct, problems = compare_plans(change, snakemake, dvc)
    assert bool(direct) != name.startswith("a comment")
    assert not problems


def test_jobs_read_what_they_declare_and_nothing_else(snakemake: Path) -> None:
    jobs = planned(snakemake, "--forceall")
    for name in READS:
        inputs, outputs, command = jobs[name]
        reads = watch(snakemake, command)
        assert len(reads.files) > len(inputs)
        assert not undeclared(snakemake, command, inputs, outputs, SMOKE[1], reads)


def test_a_file_that_is_not_declared_is_found(snakemake: Path) -> None:
    inputs, outputs, command = planned(snakemake, "--forceall")["filter"]
    index = "results/scenes/index/synscapes/0000.csv"
    reads = watch(snakemake, command)
    problems = undeclared(snakemake, command, inputs - {index}, outputs, SMOKE[1], reads)
    assert f"reads {snakemake / index}" in problems
