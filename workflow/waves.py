"""Run Snakemake step by step: `make update`, or `python workflow/waves.py [options of snakemake]`.

One call of Snakemake plans all that follows a change before it runs anything, so an edited docstring of the fog core
would train every network again. Called for one step after the other, it compares contents before each step, and stops
where results came out as they were.
"""

import subprocess
import sys

WORDS = ("scenes", "filter", "fog_airlight", "fog", "subset", "train", "evaluate")


def waves(rules: list[str]) -> list[list[str]]:
    """Rules to run up to in each call, in the order of the steps; trainings of row C go before the others.

    >>> waves(["all", "filter", "train_bisenet_C", "train_bisenet_FS-498", "subset_C"])
    [['filter'], ['subset_C'], ['train_bisenet_C'], ['train_bisenet_FS-498']]
    """
    steps: list[list[str]] = []
    for word in WORDS:
        members = [rule for rule in rules if rule == word or (rule.startswith(f"{word}_") and rule not in WORDS)]
        first = [rule for rule in members if word == "train" and rule.endswith("_C")]
        steps += [first, [rule for rule in members if rule not in first]]
    return [step for step in steps if step]


def main(options: list[str]) -> int:
    """Run all waves with these options; the exit status of the first that fails, or 0."""
    snakemake = [sys.executable, "-m", "snakemake", *options]
    if "--configfile" not in options:
        snakemake += ["--configfile", "params.yaml"]
    listed = subprocess.run([*snakemake, "--list-rules"], capture_output=True, text=True, check=False)
    if listed.returncode:
        print(listed.stdout + listed.stderr, file=sys.stderr)
        return listed.returncode
    for step in [*waves([line.split()[0] for line in listed.stdout.splitlines() if line]), []]:
        status = subprocess.run([*snakemake, *(["--until", *step] if step else [])], check=False).returncode
        if status:
            return status
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
