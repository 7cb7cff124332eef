def network_settings(network, row):
    """What of a network's settings a training reads: its shape, and the policy of its kind."""
    values = getattr(PARAMS.train, network).model_dump(mode="json", by_alias=True)
    policy = (
        ["fine_tuning"]
        if row in PARAMS.train.from_baseline
        else ["baseline", "weights"]
    )
    return json.dumps(
        {key: values[key] for key in ["backbone", "width", "decoder", *policy]},
        sort_keys=True,
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
                start=(
                    [f"results/train/{network}/C/seed-{{seed}}/model.safetensors"]
                    if row in PARAMS.train.from_baseline
                    else []
                ),
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
            params:
                network=network,
                row=row,
                train=section(
                    "train", "threads", "device", "precision", "memory_format", "curve"
                ),
                network_settings=network_settings(network, row),
                length=json.dumps(
                    PARAMS.train.rows[row].model_dump(mode="json")
                    if row in PARAMS.train.rows
                    else None
                ),
                roots=roots("synscapes", "cityscapes", "foggy_cityscapes"),
            shell:
                "foggy train --network {params.network} --row {params.row} --seed {wildcards.seed}{PARAMS_OPTION}"
                " > {log:q} 2>&1"
