rule filter:
    """Keep frames by their metadata."""
    input:
        index=index_parts("synscapes"),
        code=code("filter"),
    output:
        "results/filter/frames.csv",
        "results/filter/kept.csv",
        "results/filter/run.json",
    log:
        "results/logs/filter.log",
    benchmark:
        "results/benchmarks/filter.tsv"
    resources:
        mem_mb=memory(1_000),
        runtime=60,
    params:
        versions=versions("filter"),
        reads=reads("filter", "scenes.shards"),
    shell:
        "foggy filter{PARAMS_OPTION} > {log:q} 2>&1"
