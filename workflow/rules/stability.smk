rule stability:
    """Check the numbers at the extremes of their inputs: `snakemake --cores 1 stability`."""
    input:
        code=code("stability"),
    output:
        report(
            "results/stability/stability.csv",
            caption="../report/stability.rst",
            category="3. Numbers at their extremes",
            labels={"what": "every check"},
        ),
        "results/stability/stability.tex",
        report(
            "results/stability/stability.png",
            caption="../report/stability.rst",
            category="3. Numbers at their extremes",
            labels={"what": "errors by number format"},
        ),
        "results/stability/stability.pdf",
        "results/stability/run.json",
    log:
        "results/logs/stability/stability.log",
    benchmark:
        "results/benchmarks/stability/stability.tsv"
    resources:
        mem_mb=memory(2_000),
        runtime=60,
    params:
        versions=versions("stability"),
        reads=reads("stability"),
    shell:
        "foggy stability{PARAMS_OPTION} > {log:q} 2>&1"
