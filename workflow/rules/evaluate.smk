for step in steps("evaluate"):

    rule:
        """Score one model on one test set."""
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
        threads: threads_of(step)
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
