rule tradeoff:
    """Weigh time against accuracy: `snakemake --cores 1 tradeoff`. Its times differ run by run, so `all` leaves it out."""
    input:
        "results/tradeoff/fog.run.json",
        "results/tradeoff/networks.run.json",


rule tradeoff_fog:
    """Ways of computing fog."""
    input:
        index_parts("synscapes"),
        kept="results/filter/kept.csv",
        code=code("tradeoff"),
    output:
        expand("results/tradeoff/fog.{ending}", ending=["csv", "tex", "md"]),
        expand("results/tradeoff/fog.{ending}", ending=["pdf", "run.json"]),
        report(
            "results/tradeoff/fog.png",
            caption="../report/tradeoff_fog.rst",
            category="4. Speed against accuracy",
            labels={"of": "fog"},
        ),
    log:
        "results/logs/tradeoff/fog.log",
    benchmark:
        "results/benchmarks/tradeoff/fog.tsv"
    resources:
        mem_mb=memory(4_000),
        runtime=120,
    params:
        versions=versions("tradeoff"),
        reads=reads(
            "tradeoff.betas",
            "tradeoff.frames",
            "tradeoff.repeats",
            "scenes.roots.synscapes",
            "scenes.shards",
        ),
    shell:
        "foggy tradeoff --part fog{PARAMS_OPTION} > {log:q} 2>&1"


rule tradeoff_networks:
    """Ways of computing the trained networks, and what their training costs."""
    input:
        index_parts(PARAMS.tradeoff.test_set),
        # Shards too: training images are read to calibrate 8 bits, and to time training.
        expand(
            "results/subset/{row}/train.csv",
            row=[PARAMS.tradeoff.row, *PARAMS.subset.pure],
        ),
        expand(
            "results/fog/beta_{beta}/{shard}.tar", beta=PARAMS.fog.betas, shard=SHARDS
        ),
        models=expand(
            "results/train/{network}/{row}/seed-{seed}/model.safetensors",
            network=PARAMS.train.networks,
            row=PARAMS.tradeoff.row,
            seed=PARAMS.train.seeds[0],
        ),
        scores=expand(
            f"{EVALUATED}/metrics.json",
            test_set=PARAMS.tradeoff.test_set,
            network=PARAMS.train.networks,
            row=list(PARAMS.subset.pure),
            seed=PARAMS.train.seeds[0],
        ),
        code=code("tradeoff"),
    output:
        expand("results/tradeoff/networks.{ending}", ending=["csv", "tex", "md"]),
        expand("results/tradeoff/networks.{ending}", ending=["pdf", "run.json"]),
        report(
            "results/tradeoff/networks.png",
            caption="../report/tradeoff_networks.rst",
            category="4. Speed against accuracy",
            labels={"of": "networks"},
        ),
        expand("results/tradeoff/training.{ending}", ending=["csv", "tex"]),
    log:
        "results/logs/tradeoff/networks.log",
    benchmark:
        "results/benchmarks/tradeoff/networks.tsv"
    resources:
        mem_mb=memory(8_000),
        runtime=600,
    params:
        versions=versions("tradeoff"),
        reads=reads(
            "tradeoff.row",
            "tradeoff.test_set",
            "tradeoff.scales",
            "tradeoff.calibration",
            "tradeoff.steps",
            "scenes.roots",
            "scenes.zurich_list",
            "subset.pure",
            "train",
        ),
    shell:
        "foggy tradeoff --part networks{PARAMS_OPTION} > {log:q} 2>&1"
