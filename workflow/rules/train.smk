for step in steps("train"):

    rule:
        """Train one network on one list: from its weights, or from the selected snapshot of the baseline."""
        name:
            step.rule
        input:
            inputs(step),
            shards=waits(step),
        output:
            outputs(step),
        log:
            log_file(step),
        benchmark:
            benchmark_file(step)
        wildcard_constraints:
            **constraints(step),
        priority: step.priority
        threads: threads_of(step)
        resources:
            mem_mb=memory(step),
            runtime=step.minutes,
            gpu=gpus(step),
        params:
            command=command(step),
            reads=reads(step),
        message:
            MESSAGE
        shell:
            "{params.command} > {log:q} 2>&1"
