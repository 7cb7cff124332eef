rule tradeoff:
    """Weigh time against accuracy: `snakemake --cores 1 tradeoff`. Its times differ run by run, so `all` leaves it out."""
    input:
        index_parts("synscapes"),
        kept="results/filter/kept.csv",
        code=code("tradeoff"),
    output:
        "results/tradeoff/fog.csv",
        "results/tradeoff/fog.tex",
        "results/tradeoff/fog.md",
        "results/tradeoff/fog.png",
        "results/tradeoff/fog.pdf",
        "results/tradeoff/run.json",
    log:
        "results/logs/tradeoff/tradeoff.log",
    benchmark:
        "results/benchmarks/tradeoff/tradeoff.tsv"
    resources:
        mem_mb=memory(4_000),
        runtime=120,
    params:
        versions=versions("tradeoff"),
        reads=reads("tradeoff", "scenes.roots.synscapes", "scenes.shards"),
    shell:
        "foggy tradeoff{PARAMS_OPTION} > {log:q} 2>&1"
