def shown(what):
    """A file's place in the report."""
    return {
        "caption": "../report/atlas.rst",
        "category": "5. Fog models against path tracing",
        "labels": {"what": what},
    }


SHOWN = {
    "csv": shown("every case"),
    "png": shown("one frame in every model"),
}

for step in steps("atlas"):

    rule:
        """Score the fog models against path tracing: `snakemake --cores 1 atlas`. Its times differ run by run."""
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
