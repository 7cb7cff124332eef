for step in steps("view"):

    rule:
        """Make the page on which predictions on one test set are looked at."""
        name:
            step.rule
        input:
            inputs(step),
        output:
            outputs(step),
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
