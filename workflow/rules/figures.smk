def shown(step):
    """A figure's place in the report."""
    return {
        "png": {
            "caption": "../report/figures.rst",
            "category": "2. Figures",
            "labels": {"figure": step.command.split()[-1]},
        }
    }


def text(step):
    """What a figure shows, for its caption: a function, because Snakemake would fill in what is in braces."""
    return lambda wildcards: step.text


for step in steps("figures"):

    rule:
        """Draw one figure."""
        name:
            step.rule
        input:
            inputs(step),
        output:
            outputs(step, **shown(step)),
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
            text=text(step),
        message:
            MESSAGE
        shell:
            "{params.command} > {log:q} 2>&1"
