rule tradeoff:
    """Speed against accuracy: `snakemake --cores 1 tradeoff`. Its times differ run by run, so `all` leaves it out."""
    input:
        [path for step in steps("tradeoff") for path in outputs(step)],


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
        """Measure what cheaper ways of computing save and cost."""
        name:
            step.name
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
        shell:
            "{params.command}{PARAMS_OPTION} > {log:q} 2>&1"
