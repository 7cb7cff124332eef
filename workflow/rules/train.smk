for network in PARAMS.train.networks:
    for row in ROWS:

        rule:
            """Train one network on one list: from its weights, or from the selected snapshot of row C."""
            name:
                f"train_{network}_{row}"
            input:
                lists=expand("results/subset/{row}/{part}.csv", row=row, part=["train", "validation"]),
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
            params:
                network=network,
                row=row,
                train=section("train", "threads", "workers", "precision", network),
                length=json.dumps(
                    PARAMS.train.rows[row].model_dump(mode="json") if row in PARAMS.train.rows else None
                ),
                scenes=section("scenes", "roots"),
            threads: PARAMS.train.threads
            # Fine-tunings wait for row C, so it goes first.
            priority: 100 if row == "C" else 0
            log:
                f"results/logs/train/{network}_{row}_seed-{{seed}}.log",
            benchmark:
                f"results/benchmarks/train/{network}_{row}_seed-{{seed}}.tsv"
            shell:
                "foggy train --network {params.network} --row {params.row} --seed {wildcards.seed}{PARAMS_OPTION}"
                " > {log:q} 2>&1"
