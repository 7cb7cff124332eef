def figure_sources(figure):
    """What a figure is drawn from."""
    if figure in ("beta_strip", "fc_against_fs"):
        return [*index_parts("synscapes"), *PARTIAL, "results/filter/kept.csv"]
    if figure == "sky_contrast":
        return ["results/filter/frames.csv"]
    if figure == "curves":
        return expand(
            "results/train/{network}/{row}/seed-{seed}/curves.csv",
            network=PARAMS.train.networks,
            row=ROWS,
            seed=PARAMS.train.seeds,
        )
    for kind in ("class_change_", "confusion_"):
        if figure.startswith(kind):
            return evaluations(figure.removeprefix(kind), "metrics.json")
    test_set = figure.removeprefix("predictions_")
    scores = evaluations(test_set, "metrics.json") + evaluations(
        test_set, "predictions.tar"
    )
    return index_parts(test_set) + scores


def figure_reads(figure):
    """Params that a figure is drawn by, beside its own section."""
    if figure in ("beta_strip", "fc_against_fs"):
        return [
            "fog.geometry",
            "scenes.refined_list",
            "scenes.shards",
        ]
    if figure == "sky_contrast":
        return ["filter", "scenes.roots"]
    keys = [*RUNS, "tables.rows.row"]
    if figure != "curves":
        keys.append("scenes.roots")
    return keys + (["scenes.zurich_list"] if figure.startswith("predictions") else [])


rule figures:
    """Draw one figure."""
    input:
        lambda wildcards: figure_sources(wildcards.figure),
        code=code("figures"),
    output:
        report(
            "results/figures/{figure}.png",
            caption="../report/figures.rst",
            category="2. Figures",
            labels={"figure": "{figure}"},
        ),
        "results/figures/{figure}.pdf",
        "results/figures/{figure}.run.json",
    log:
        "results/logs/figures/{figure}.log",
    benchmark:
        "results/benchmarks/figures/{figure}.tsv"
    resources:
        mem_mb=memory(4_000),
        runtime=60,
    params:
        versions=versions("figures"),
        reads=lambda wildcards: reads("figures", *figure_reads(wildcards.figure))(
            wildcards
        ),
    shell:
        "foggy figures --figure {wildcards.figure}{PARAMS_OPTION} > {log:q} 2>&1"
