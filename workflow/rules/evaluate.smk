RUNS = [
    f"train.{key}" for key in ["networks", "seeds", "from_weights", "from_baseline"]
]
EVALUATED = "results/evaluate/{test_set}/{network}/{row}/seed-{seed}"


def evaluations(test_set, file):
    """One file of every model's evaluation on a test set."""
    return expand(
        f"{EVALUATED}/{file}",
        test_set=test_set,
        network=PARAMS.train.networks,
        row=ROWS,
        seed=PARAMS.train.seeds,
    )


rule evaluate:
    """Score one model on one test set."""
    input:
        model="results/train/{network}/{row}/seed-{seed}/model.safetensors",
        index=lambda wildcards: index_parts(wildcards.test_set),
        code=code("evaluate"),
    output:
        f"{EVALUATED}/metrics.json",
        f"{EVALUATED}/predictions.tar",
        f"{EVALUATED}/run.json",
    log:
        "results/logs/evaluate/{test_set}_{network}_{row}_seed-{seed}.log",
    benchmark:
        "results/benchmarks/evaluate/{test_set}_{network}_{row}_seed-{seed}.tsv"
    threads: PARAMS.evaluate.threads
    resources:
        mem_mb=memory(4_000),
        runtime=12 * 60,
    params:
        versions=versions("evaluate"),
        reads=lambda wildcards: reads(
            "evaluate.threads",
            "scenes.zurich_list",
        )(wildcards),
    shell:
        "foggy evaluate --network {wildcards.network} --row {wildcards.row} --seed {wildcards.seed}"
        " --test-set {wildcards.test_set}{PARAMS_OPTION} > {log:q} 2>&1"
