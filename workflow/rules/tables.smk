SHOWN = {
    "html": {
        "caption": "../report/tables.rst",
        "category": "1. Tables",
        "labels": {"test set": "{test_set}"},
    }
}

for step in steps("tables"):

    rule:
        """Print the scores of all rows on one test set, beside the published ones."""
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
