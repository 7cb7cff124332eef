AIRLIGHT_READS = (
    "fog.frames",
    "fog.blue_airlight",
    "scenes.shard_frames",
)


rule fog_airlight:
    """Estimate the atmospheric light of a shard's frames, once for all betas."""
    input:
        index="results/scenes/index/synscapes/{shard}.csv",
        kept="results/filter/kept.csv",
        code=code("fog"),
    output:
        "results/fog/airlight/{shard}.csv",
        "results/fog/airlight/{shard}.run.json",
    log:
        "results/logs/fog/airlight_{shard}.log",
    benchmark:
        "results/benchmarks/fog/airlight_{shard}.tsv"
    resources:
        mem_mb=memory(1_000),
        runtime=120,
    params:
        versions=versions("fog"),
        reads=reads(*AIRLIGHT_READS),
    shell:
        "foggy fog --airlight --shard {wildcards.shard}{PARAMS_OPTION} > {log:q} 2>&1"


rule fog:
    """Render the foggy images of one shard at one beta."""
    input:
        index="results/scenes/index/synscapes/{shard}.csv",
        kept="results/filter/kept.csv",
        airlight="results/fog/airlight/{shard}.csv",
        code=code("fog"),
    output:
        "results/fog/beta_{beta}/{shard}.tar",
        "results/fog/beta_{beta}/{shard}.csv",
        "results/fog/beta_{beta}/{shard}.run.json",
    log:
        "results/logs/fog/beta_{beta}_{shard}.log",
    benchmark:
        "results/benchmarks/fog/beta_{beta}_{shard}.tsv"
    resources:
        mem_mb=memory(1_000),
        runtime=120,
    params:
        versions=versions("fog"),
        reads=reads(*AIRLIGHT_READS, "fog.geometry", "fog.png_level", "fog.render"),
    shell:
        "foggy fog --beta {wildcards.beta} --shard {wildcards.shard}{PARAMS_OPTION} > {log:q} 2>&1"
