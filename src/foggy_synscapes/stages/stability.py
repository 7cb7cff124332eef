"""stability: fog, losses and scores at the extremes of their inputs, each against an answer known beforehand."""

import argparse

import pandas as pd

from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.stability import fog_checks, kernel_checks, other_checks
from foggy_synscapes.stability.check import COLUMNS, FAILS, Check, summary
from foggy_synscapes.steps import job

HELP = "Check fog, airlight, learning rate, losses and scores at the extremes, in each number format."


def arguments(parser: argparse.ArgumentParser) -> None:
    """This step has no options of its own."""


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    stability(load(args.params))


def stability(params: Params) -> list[Check]:
    """Write the table (CSV, LaTeX, Markdown) and the plot (PNG, PDF) to results/stability, and return the checks."""
    from foggy_synscapes.figures.errors import errors
    from foggy_synscapes.figures.style import render
    from foggy_synscapes.stability import training_checks
    from foggy_synscapes.tables.formats import long_latex, long_markdown

    run = Run(job(params, "stability"))
    digits = params.stability.digits
    checks = [*fog_checks.checks(digits), *kernel_checks.checks(digits, params.stability.searched)]
    checks += [*training_checks.checks(), *other_checks.checks()]
    table = pd.DataFrame([check.row() for check in checks], columns=COLUMNS)
    caption = f"Numbers at the extremes, against mpmath at {digits} digits."
    figure = errors(fog_checks.curves(digits))
    run.write(
        csv=table.to_csv(index=False, lineterminator="\n"),
        tex=long_latex(table, caption, "table:stability"),
        md=f"{caption}\n\n{summary(checks)}\n\n{long_markdown(table)}\n",
        **{ending: render(figure, ending) for ending in ("png", "pdf")},
    )
    run.finish()
    failed = sum(check.verdict == FAILS for check in checks)
    print(f"stability: {len(checks)} checks; {failed} show where a plain formula or a short number format fails")
    return checks
