def figure_sources(figure):
    """What a figure is drawn from."""
    if figure in ("beta_strip", "fc_against_fs"):
        return [*index_parts("synscapes"), *PARTIAL, "results/filter/kept.csv"]
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


rule figures:
    """Draw one figure."""
    input:
        lambda wildcards: figure_sources(wildcards.figure),
        code=code("figures"),
    output:
        "results/figures/{figure}.png",
        "results/figures/{figure}.pdf",
        "results/figures/{figure}.run.json",
    log:
        "results/logs/figures/{figure}.log",
    benchmark:
        "results/benchmarks/figures/{figure}.tsv"
    params:
        figures=section("figures"),
        fog=section("fog", "geometry"),
        train=section("train", "networks", "seeds", "from_weights", "from_baseline"),
        tables=section("tables", "rows"),
        scenes=section("scenes", "roots", "refined_list", "zurich_list", "shards"),
    shell:
        "foggy figures --figure {wildcards.figure}{PARAMS_OPTION} > {log:q} 2>&1"
