def shown(part):
    """The place in the report of a part's figure, or of its text where it has none."""
    return {
        "md" if part == "accuracy" else "png": {
            "caption": f"../report/tradeoff_{part}.rst",
            "category": "4. Speed against accuracy",
            "labels": {"of": part},
        }
    }


for step in steps("tradeoff"):

    rule:
        """What cheaper ways of computing save and cost. Times differ run by run: `all` leaves it out, `tradeoff` asks for it."""
        name:
            step.rule
        input:
            inputs(step),
            shards=waits(step),
        output:
            outputs(step, **shown(step.name.removeprefix("tradeoff_"))),
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
