for step in steps("fog"):

    rule:
        """Estimate the airlight of a shard's frames, once for all betas; render their foggy images at one beta."""
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
