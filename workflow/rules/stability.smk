def shown(what):
    """A file's place in the report."""
    return {
        "caption": "../report/stability.rst",
        "category": "3. Numbers at their extremes",
        "labels": {"what": what},
    }


SHOWN = {
    "md": shown("what does not hold"),
    "csv": shown("every check"),
    "png": shown("errors by number format"),
}

for step in steps("stability"):

    rule:
        """Check the numbers at the extremes of their inputs: `snakemake --cores 1 stability`."""
        name:
            step.rule
        input:
            inputs(step),
        output:
            outputs(step, **SHOWN),
        log:
            log_file(step),
        benchmark:
            benchmark_file(step)
        wildcard_constraints:
            **constraints(step),
        resources:
            mem_mb=memory(step),
            runtime=step.minutes,
        params:
            command=command(step),
            reads=reads(step),
        message:
            MESSAGE
        shell:
            "{params.command} > {log:q} 2>&1"
