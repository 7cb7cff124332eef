"""Run Snakemake step by step: `make update`, or `python workflow/waves.py [options of snakemake]`.

One call of Snakemake plans all that follows a change before it runs anything, so another way of computing the same fog
would train every network again. Called for one step after the other, it compares contents before each step, and stops
where results came out as they were.
"""

import subprocess
import sys

from foggy_synscapes.steps import steps


def main(options: list[str]) -> int:
    """Run up to each step in turn with these options; the exit status of the first that fails, or 0."""
    snakemake = [sys.executable, "-m", "snakemake", *options]
    if "--configfile" not in options:
        snakemake += ["--configfile", "params.yaml"]
    for until in [*(["--until", step.rule] for step in steps() if step.default), []]:
        status = subprocess.run([*snakemake, *until], check=False).returncode
        if status:
            return status
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
