"""Params: what is wrong is named by its key, and nothing wrong passes."""

from copy import deepcopy
from pathlib import Path

import pytest

from foggy_synscapes import params
from foggy_synscapes.betas import beta_name
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.plain_yaml import read_yaml

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def document() -> dict:
    return read_yaml(ROOT / "params.yaml")


def set_in(document: dict, key: str, value: object) -> dict:
    changed = deepcopy(document)
    *path, last = key.split(".")
    place = changed
    for part in path:
        place = place[part]
    place[last] = value
    return changed


@pytest.mark.parametrize("name", ["params.yaml", "params/smoke.yaml", "params/paper.yaml", "params/discussion.yaml"])
def test_each_shipped_file_is_good(name: str) -> None:
    params.load(ROOT / name)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("fog.betta", "0.005", "fog.betta: unknown key; did you mean beta"),
        ("fog.betas", ["0.005", "-0.01"], "fog.betas.1: beta -0.01 is not a positive finite number"),
        ("fog.betas", ["0.005; touch x"], "fog.betas.0: beta '0.005; touch x' is not a number"),
        ("fog.betas", ["nan"], "not a positive finite number"),
        ("fog.betas", ["inf"], "not a positive finite number"),
        ("fog.betas", ["0"], "not a positive finite number"),
        ("fog.betas", ["0.0050"], "write '0.005', as the folder spells it"),
        ("fog.betas", ["5e-3"], "write '0.005', as the folder spells it"),
        ("fog.betas", ["0.005", "0.005"], "each once"),
        ("fog.betas", [0.005], 'fog.betas.0: a number; write it in quotes, "0.005"'),
        ("fog.betas", [1e-5], 'write it in quotes, "0.00001"'),
        ("train.seeds", [0], 'train.seeds.0: a number; write it in quotes, "0"'),
        ("train.seeds", [True], "train.seeds.0: Input should be a valid string; got True"),
        ("fog.betas", ["0.02"], "no list in subset uses 0.02"),
        ("fog.geometry", "flat", "fog.geometry"),
        ("fog.frames.first", 10, "the first 600 and the last 60 kept frames"),
        ("scenes.shards", ["0000"], "are 4 shards"),
        ("scenes.stand_in.foggy_cityscapes.train", 401, "401 refined frames of only 400"),
        ("subset.clear", {}, "train: trains rows"),
        ("subset.clear", {"../C": {"train": 1, "validation": 1}}, "subset.clear.../C"),
        ("train.seeds", ["$(x)"], "train.seeds.0"),
        ("train.rows.FC-498.length", {"epochs": 1, "iterations": 1}, "give either images, epochs or iterations"),
        ("train.rows.FC-498.length", {"iterations": 0}, "greater than or equal to 1"),
        ("train.threads", "many", "train.threads"),
        ("train.threads", "2", "train.threads: should be a number, without quotes"),
        ("train.threads", True, "train.threads: should be a number"),
        ("train.threads", 2.0, "train.threads: should be a whole number"),
        ("train.bisenet.baseline.learning_rate", "1e-3", "with a point where it has an exponent (1.0e-3); got '1e-3'"),
        ("gpu.tf32", 1, "gpu.tf32: should be true or false; got 1"),
        ("train.seeds", ["0", "00"], "train.seeds: each once"),
        ("train.networks", ["bisenet", "bisenet"], "train.networks: each once"),
        ("train.networks", ["bisnet"], "networks: bisnet is no network; there are bisenet, refinenet"),
        ("train.precision", "measured", "train.precision"),
        ("plugins", "nowhere", "plugins: nowhere is no folder"),
        ("plugins", 3, "plugins: "),
        ("evaluate.test_sets", ["foggy_zurich", "foggy_zurich"], "evaluate.test_sets: each once"),
        ("train.bisenet.baseline.learning_rate", float("inf"), "train.bisenet.baseline.learning_rate"),
        ("filter.rules", [{"key": "sky_contrast", "maximum": float("nan")}], "filter.rules.0.maximum"),
        ("filter.rules", [{"key": "sky_contrast", "minimum": 3, "maximum": 2}], "minimum 3.0 is above maximum 2.0"),
        ("scenes.refined_list", "../../x.txt", "scenes.refined_list"),
        ("scenes.refined_list", "/etc/x.txt", "scenes.refined_list"),
        ("scenes.roots.synscapes", "", "scenes.roots.synscapes"),
    ],
)
def test_a_wrong_value_is_named_by_its_key(document: dict, key: str, value: object, message: str) -> None:
    with pytest.raises(FoggyError) as caught:
        params.check(set_in(document, key, value), "params.yaml")
    assert message in str(caught.value)
    assert str(caught.value).startswith("params.yaml: ")


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("treads", "train.treads: unknown key; did you mean threads?"),
        ("bisnet", "train.bisnet: unknown key; did you mean bisenet?"),
    ],
)
@pytest.mark.parametrize("value", [3, {"width": 16}])
def test_a_misspelt_network_or_key_of_train_is_told_apart_from_settings(key: str, value: object, message: str) -> None:
    with pytest.raises(FoggyError) as caught:
        params.check({"train": {key: value, "threads": 0}}, "params.yaml")
    first, second = str(caught.value).splitlines()
    assert message in first
    assert "train.threads" in second


def test_what_has_no_default_is_named_where_it_is_missing() -> None:
    with pytest.raises(FoggyError, match=r"subset\.clear\.C\.validation: missing"):
        params.check({"subset": {"clear": {"C": {"train": 1}}}}, "params.yaml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: &x [1]\nb: *x\n", "aliases are not allowed"),
        ("a: !!python/object/apply:os.system ['touch gone']\n", "could not determine a constructor"),
        ("a: 1\na: 2\n", "key 'a' stands twice"),
        ("a: [", "not a readable params file"),
        ("- 1\n", "expected sections"),
        ("", "expected sections"),
    ],
)
def test_yaml_that_is_not_plain_data_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(text)
    with pytest.raises(FoggyError, match=message):
        params.load(path)


def test_a_missing_file_says_where_others_are(tmp_path: Path) -> None:
    with pytest.raises(FoggyError, match=r"none\.yaml: missing"):
        params.load(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("text", "name"), [("0.06", "0.06"), ("1e-12", "0.000000000001"), ("1", "1.0"), ("0.0100", "0.01")]
)
def test_a_beta_has_one_spelling(text: str, name: str) -> None:
    assert beta_name(text) == name
