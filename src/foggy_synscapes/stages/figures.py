"""figures: the pictures that people want first."""

import argparse

from foggy_synscapes.errors import UsageError
from foggy_synscapes.figures import FIGURES
from foggy_synscapes.figures.sources import Sources
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import roots
from foggy_synscapes.steps import of

HELP = "Draw a figure: fog at each beta, FC against FS, sky contrast, predictions of each row, training curves."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    names = [f"{name}_TESTSET" if FIGURES[name].of_test_set else name for name in FIGURES]
    parser.add_argument("--figure", required=True, metavar="NAME", help=", ".join(names))


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    figures(load(args.params), args.figure)


def figures(params: Params, name: str) -> None:
    """Draw one figure and write it as PNG and PDF to results/figures.

    Raises
    ------
    UsageError
        If there is no figure of this name.
    FoggyError
        If what it shows is missing, damaged or not as listed.
    """
    from foggy_synscapes.figures.style import render

    jobs = [Job(step, params, values) for step in of("figures") for values in step.all_values(params)]
    named = {job.command[-1]: job for job in jobs}
    if name not in named:
        raise UsageError(f"--figure {name}: there are {', '.join(named)}")
    job = named[name]
    # Runs that were not made are left out of a figure.
    run = Run(job, [path for path in job.read() if path.is_file()])
    drawn = FIGURES[job.step.name.removeprefix("figures_")].draw(Sources(job, roots(params)))
    run.write(**{ending: render(drawn, ending) for ending in ("png", "pdf")})
    run.finish()
    print(f"figures {name}: {', '.join(map(str, job.outputs()))}")
