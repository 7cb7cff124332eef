"""Run records: what a step reads has to be what its maker wrote, and a record says all that decides bytes."""

import json
from pathlib import Path

import pytest
from records import vouch

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.params import check, load
from foggy_synscapes.provenance.runs import VARIABLES, Run, checked_inputs, instructions, leaves, read_run, recorded
from foggy_synscapes.steps import job

ROOT = Path(__file__).resolve().parents[2]
METRICS = Path("results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json")


@pytest.fixture(autouse=True)
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two files of one step, and its record."""
    monkeypatch.chdir(tmp_path)
    write_text(METRICS, "{}")
    write_text(METRICS.with_name("predictions.tar"), "tar")
    this = job(load(ROOT / "params.yaml"), "evaluate", test_set="foggy_zurich", network="bisenet", row="C", seed="0")
    Run(this, read=[]).finish()


def test_what_a_step_wrote_is_taken_with_its_hash() -> None:
    assert checked_inputs([METRICS]) == {METRICS.as_posix(): sha256(METRICS)}


def test_a_file_that_was_changed_by_hand_is_refused_with_what_to_do() -> None:
    write_text(METRICS, '{"mean_iou": 99}')
    with pytest.raises(FoggyError) as caught:
        checked_inputs([METRICS])
    message = str(caught.value)
    assert message.startswith(f"{METRICS}: is not what its step wrote")
    assert f"{METRICS.with_name('run.json')} has sha256" in message
    assert "Make it again: foggy evaluate --network bisenet" in message


def test_a_file_whose_step_was_cut_off_before_its_record_is_refused() -> None:
    METRICS.with_name("run.json").unlink()
    with pytest.raises(FoggyError, match=r"no run record beside it .*Was its step cut off"):
        checked_inputs([METRICS])


def test_a_file_that_its_neighbours_record_does_not_name_is_refused() -> None:
    write_text(METRICS.with_name("other.json"), "{}")
    with pytest.raises(FoggyError, match=r"other\.json: is not what its step wrote.*does not name it"):
        checked_inputs([METRICS.with_name("other.json")])


def test_a_missing_file_is_named() -> None:
    METRICS.unlink()
    with pytest.raises(FoggyError, match=r"metrics\.json: missing\. It is made by an earlier step"):
        checked_inputs([METRICS])


@pytest.mark.parametrize("text", ["", "[]", '{"command": []}', '{"outputs": {}, "inputs": {}, "com'])
def test_a_record_that_is_half_written_is_named(text: str) -> None:
    write_text(METRICS.with_name("run.json"), text)
    with pytest.raises(FoggyError, match=r"run\.json: not a (readable )?run record.*Run its step again"):
        checked_inputs([METRICS])


def test_files_outside_of_results_have_no_maker_and_are_hashed() -> None:
    write_text(Path("weights.safetensors"), "w")
    assert checked_inputs(["weights.safetensors"]) == {"weights.safetensors": sha256("weights.safetensors")}


def test_records_beside_each_other_vouch_for_their_own_files_only() -> None:
    for name in ("a", "b"):
        write_text(Path(f"results/tables/{name}.csv"), name)
        write_text(Path(f"results/tables/{name}.run.json"), json.dumps({"command": [], "inputs": {}, "outputs": {}}))
        vouch(f"results/tables/{name}.csv")
    assert len(checked_inputs(["results/tables/a.csv", "results/tables/b.csv"])) == 2
    write_text(Path("results/tables/a.csv"), "b")
    with pytest.raises(FoggyError, match=r"a\.csv: is not what its step wrote.*tables/a\.run\.json"):
        checked_inputs(["results/tables/a.csv", "results/tables/b.csv"])


def test_a_record_names_versions_code_and_instruction_set() -> None:
    record = read_run(METRICS.with_name("run.json"))
    assert record["code"].keys() >= {"stages.evaluate", "networks.bisenet_layers", "datasets.foggy_zurich"}
    assert record["versions"].keys() >= {"python", "foggy-synscapes", "numpy"}
    assert record["instructions"] == instructions()
    assert record["instructions"]["machine"]
    assert record["instructions"]["extensions"]


@pytest.mark.parametrize("name", VARIABLES)
def test_a_variable_that_can_change_a_number_is_recorded(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(name, "1")
    assert instructions()[name] == "1"


def test_folders_of_the_machine_are_not_recorded() -> None:
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"]["synscapes"] = "/home/me/synscapes"
    document["train"]["bisenet"]["weights"] = "/home/me/resnet18.safetensors"
    params = check(document, "params.yaml")
    record = recorded(params, "scenes", "train.bisenet.weights", "fog.betas")
    assert record["scenes"]["roots"] == {
        **dict.fromkeys(params.scenes.roots, "stand-in"),
        "synscapes": "real",
    }
    assert record["train"] == {"bisenet": {"weights": "imported"}}
    assert record["fog"] == {"betas": ["0.005"]}
    assert "/home/me" not in json.dumps(record)
    assert dict(leaves(record))["scenes.roots.synscapes"] == "real"
    with pytest.raises(KeyError):
        recorded(params, "fog.beta")
