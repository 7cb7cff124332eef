rule tables:
    """Print the scores of all rows on one test set, beside the published ones."""
    input:
        metrics=lambda wildcards: evaluations(wildcards.test_set, "metrics.json"),
        code=code("tables"),
    output:
        "results/tables/{test_set}.csv",
        "results/tables/{test_set}.tex",
        "results/tables/{test_set}.md",
        report(
            "results/tables/{test_set}.html",
            caption="../report/tables.rst",
            category="1. Tables",
            labels={"test set": "{test_set}"},
        ),
        "results/tables/{test_set}.json",
        "results/tables/{test_set}.run.json",
    log:
        "results/logs/tables/{test_set}.log",
    benchmark:
        "results/benchmarks/tables/{test_set}.tsv"
    resources:
        mem_mb=memory(1_000),
        runtime=30,
    params:
        versions=versions("tables"),
        reads=reads("tables", "subset", "scenes.roots", *RUNS),
    shell:
        "foggy tables --test-set {wildcards.test_set}{PARAMS_OPTION} > {log:q} 2>&1"
