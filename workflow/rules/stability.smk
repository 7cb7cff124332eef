rule stability:
    """Check the numbers at the extremes of their inputs: `snakemake --cores 1 stability`."""
    input:
        code=code("stability"),
    output:
        "results/stability/stability.csv",
        "results/stability/stability.tex",
        "results/stability/stability.png",
        "results/stability/stability.pdf",
        "results/stability/run.json",
    log:
        "results/logs/stability/stability.log",
    benchmark:
        "results/benchmarks/stability/stability.tsv"
    params:
        versions=versions("stability"),
        stability=section("stability"),
    shell:
        "foggy stability{PARAMS_OPTION} > {log:q} 2>&1"
