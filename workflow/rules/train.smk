def train_reads(network, row):
    """Params that decide what a training gives: not its workers or memory."""
    own = (
        ["fine_tuning"]
        if row in PARAMS.train.from_baseline
        else ["baseline", "weights"]
    )
    keys = [f"{network}.{key}" for key in ["backbone", "width", "decoder", *own]]
    keys += ["threads", "device", "precision", "memory_format", "compile", "curve"]
    keys += [f"rows.{row}"]
    return [f"train.{key}" for key in keys]


def start_weights(network, row):
    """What a training starts from: the baseline's model, or the file of its weights where that is there.

    The file is not asked for where it is missing, so that an experiment can be planned before it is imported.
    """
    if row in PARAMS.train.from_baseline:
        return [f"results/train/{network}/C/seed-{{seed}}/model.safetensors"]
    weights = PARAMS.train.weights(network, row)
    return [weights] if os.path.isfile(weights) else []


def fog_shards(row):
    """Shards that hold a row's images. The row's lists hold each image's hash: shards are only waited for."""
    if PARAMS.subset.kind(row) not in ("pure", "mixed"):
        return []
    beta = PARAMS.subset.rows()[row].beta
    return ancient(
        expand("results/fog/beta_{beta}/{shard}.tar", beta=beta, shard=SHARDS)
    )


for network in PARAMS.train.networks:
    for row in ROWS:

        rule:
            """Train one network on one list: from its weights, or from the selected snapshot of row C."""
            name:
                f"train_{network}_{row}"
            input:
                lists=expand(
                    "results/subset/{row}/{part}.csv",
                    row=row,
                    part=["train", "validation"],
                ),
                start=start_weights(network, row),
                shards=fog_shards(row),
                code=code("train"),
            output:
                expand(
                    "results/train/{network}/{row}/seed-{{seed}}/{file}",
                    network=network,
                    row=row,
                    file=["model.safetensors", "curves.csv", "run.json"],
                ),
            log:
                f"results/logs/train/{network}_{row}_seed-{{seed}}.log",
            benchmark:
                f"results/benchmarks/train/{network}_{row}_seed-{{seed}}.tsv"
            # Fine-tunings wait for row C, so it goes first.
            priority: 100 if row == "C" else 0
            threads: PARAMS.train.threads
            resources:
                mem_mb=memory(16_000),
                runtime=7 * 24 * 60,
                gpu=1 if PARAMS.train.device == "cuda" else 0,
            params:
                versions=versions("train"),
                network=network,
                row=row,
                reads=reads(*train_reads(network, row)),
            shell:
                "foggy train --network {params.network} --row {params.row} --seed {wildcards.seed}{PARAMS_OPTION}"
                " > {log:q} 2>&1"
