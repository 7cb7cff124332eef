def index_parts(dataset):
    """Index files of a dataset: Synscapes has one per shard."""
    parts = SHARDS if dataset == "synscapes" else ["all"]
    return [f"results/scenes/index/{dataset}/{part}.csv" for part in parts]


for name in (
    "synscapes",
    "cityscapes",
    "foggy_cityscapes",
    "foggy_driving",
    "foggy_zurich",
):

    rule:
        """Render the stand-in of one dataset where its root says so, and list what the dataset holds."""
        name:
            f"scenes_{name}"
        input:
            code=code("scenes"),
        output:
            index_parts(name),
            f"results/scenes/index/{name}/run.json",
            f"results/scenes/{name}/README.txt",
        log:
            f"results/logs/scenes/{name}.log",
        benchmark:
            f"results/benchmarks/scenes/{name}.tsv"
        resources:
            mem_mb=memory(1_000),
            runtime=12 * 60,
        params:
            versions=versions("scenes"),
            dataset=name,
            reads=reads(*PARAMS.scenes.deciding(name)),
        shell:
            "foggy scenes --dataset {params.dataset}{PARAMS_OPTION} > {log:q} 2>&1"
