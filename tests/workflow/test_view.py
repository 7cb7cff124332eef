"""Pages of a finished run by Snakemake and by the command, and the lineage of results as a picture."""

from pathlib import Path

from engines import run

TEST_SET = "foggy_zurich"
PAGE = f"results/view/{TEST_SET}.html"
SMOKE = ("--params", "params/smoke.yaml")


def test_snakemake_and_the_command_make_the_same_page(snakemake: Path) -> None:
    assert not (snakemake / "results/view").exists()  # no part of the whole experiment
    run(snakemake, "snakemake", "--cores", "1", PAGE, "--configfile", "params/smoke.yaml")
    first = (snakemake / PAGE).read_bytes()
    run(snakemake, "foggy_synscapes", "view", "--results", *SMOKE)
    assert (snakemake / PAGE).read_bytes() == first
    run(snakemake, "foggy_synscapes", "verify", PAGE)
    run(snakemake, "foggy_synscapes", "trace", PAGE, "--svg", "page.svg", *SMOKE)
    assert "foggy evaluate" in (snakemake / "page.svg").read_text()


def test_a_cell_is_drawn_with_its_value(snakemake: Path) -> None:
    cell = ("BiSeNet", "FS-498", "mean IoU annotated")
    printed = run(snakemake, "foggy_synscapes", "trace", "--cell", *cell, *SMOKE).partition("annotated: ")[2].split()[0]
    run(snakemake, "foggy_synscapes", "trace", "--cell", *cell, "--svg", "cell.svg", *SMOKE)
    picture = (snakemake / "cell.svg").read_text()
    assert f"BiSeNet FS-498, mean IoU annotated: {printed}" in picture
    for text in ("train", "evaluate", "subset", "fog", "dataset: synscapes"):
        assert f">{text}" in picture, text
