CLEAR = index_parts("cityscapes")
PARTIAL = CLEAR + index_parts("foggy_cityscapes")


def purely_synthetic(row):
    """What a list of Foggy Synscapes images is made from."""
    beta = PARAMS.subset.rows()[row].beta
    manifests = expand("results/fog/beta_{beta}/{shard}.csv", beta=beta, shard=SHARDS)
    return [*index_parts("synscapes"), "results/filter/kept.csv", *manifests]


def subset_sources(row):
    """What a list is made from, by its kind."""
    kind = PARAMS.subset.kind(row)
    if kind in ("clear", "partial"):
        return CLEAR if kind == "clear" else PARTIAL
    return purely_synthetic(row) + (PARTIAL if kind == "mixed" else [])


def subset_reads(row):
    """Params that a list is made by, by its kind."""
    kind = PARAMS.subset.kind(row)
    keys = [f"subset.{kind}.{row}"]
    if kind in ("partial", "mixed"):
        keys += ["scenes.refined_list"]
    return keys + (["scenes.shards"] if kind in ("pure", "mixed") else [])


for row in ROWS:

    rule:
        """List the images and labels of one row."""
        name:
            f"subset_{row}"
        input:
            subset_sources(row),
            code=code("subset"),
        output:
            f"results/subset/{row}/train.csv",
            f"results/subset/{row}/validation.csv",
            f"results/subset/{row}/run.json",
        log:
            f"results/logs/subset/{row}.log",
        benchmark:
            f"results/benchmarks/subset/{row}.tsv"
        resources:
            mem_mb=memory(1_000),
            runtime=30,
        params:
            versions=versions("subset"),
            row=row,
            reads=reads(*subset_reads(row)),
        shell:
            "foggy subset --row {params.row}{PARAMS_OPTION} > {log:q} 2>&1"
