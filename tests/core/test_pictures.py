"""Pictures of the workflow and of lineages: what stands in them, where, and that they are up to date."""

import re
import xml.etree.ElementTree as ElementTree
from itertools import pairwise
from pathlib import Path

import pytest

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.svg import Box, drawing
from foggy_synscapes.planning.picture import WRITES, workflow
from foggy_synscapes.provenance.lineage import Lineage
from foggy_synscapes.provenance.picture import file_svg

ROOT = Path(__file__).resolve().parents[2]
SVG = "{http://www.w3.org/2000/svg}"


def places(picture: str) -> dict[str, tuple[float, float, float, float]]:
    """Left, top, right and bottom of each box, by its title."""
    found = {}
    for group in ElementTree.fromstring(picture).iter(f"{SVG}g"):
        box, title = group.find(f"{SVG}rect"), group.find(f"{SVG}text")
        x, y, width, height = (float(box.get(key)) for key in ("x", "y", "width", "height"))
        found[title.text] = (x, y, x + width, y + height)
    return found


def texts(picture: str) -> list[str]:
    return [each.text for each in ElementTree.fromstring(picture).iter(f"{SVG}text")]


def test_the_picture_of_the_workflow_is_up_to_date() -> None:
    assert (ROOT / "docs/images/workflow.svg").read_text() == workflow(), "run `make dvc.yaml`"


def test_the_workflow_is_nine_boxes_in_their_order() -> None:
    found = places(workflow())
    assert {*found} == {*WRITES}
    assert len(found) == 9
    order = ["scenes", "filter", "complete", "fog", "subset", "train", "evaluate", "tables"]
    assert all(found[one][2] < found[other][0] for one, other in pairwise(order))
    assert found["tables"][0] == found["figures"][0]
    # No arrow where others lead the same way: evaluate reads the lists of scenes, too, from which all begins.
    assert workflow().count("marker-end") == len(found) - 1


def test_boxes_overlap_neither_each_other_nor_the_edge() -> None:
    boxes = {str(n): Box(f"box {n}", ["a line & <another>"] * (n % 4)) for n in range(30)}
    picture = drawing(boxes, [(str(n // 3), str(n)) for n in range(1, 30)], "a tree")
    found = [*places(picture).values()]
    assert len(found) == 30
    root = ElementTree.fromstring(picture)
    for number, (left, top, right, bottom) in enumerate(found):
        assert 0 < left < right < float(root.get("width"))
        assert 0 < top < bottom < float(root.get("height"))
        for x1, y1, x2, y2 in found[:number]:
            assert right <= x1 or x2 <= left or bottom <= y1 or y2 <= top


def test_a_circle_is_refused() -> None:
    with pytest.raises(ValueError, match="circle"):
        drawing({"a": Box("a"), "b": Box("b")}, [("a", "b"), ("b", "a")], "a circle")


def record(command: str, inputs: list[str], *outputs: str) -> dict:
    """A record of a job, whose files are there."""
    for name in outputs:
        write_text(Path(name), name)
    digests = {name: sha256(Path(name)) for name in (*inputs, *outputs)}
    return {
        "command": ["foggy", *command.split()],
        "inputs": {name: digests[name] for name in inputs},
        "outputs": {name: digests[name] for name in outputs},
    }


@pytest.fixture
def lineage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lineage:
    """Three hundred renderings, of which two lists and two trainings are made, and a table."""
    monkeypatch.chdir(tmp_path)
    write_text(Path("weights.txt"), "from elsewhere")
    shards = [f"results/fog/{n}.tar" for n in range(300)]
    made = [record(f"fog --airlight --shard {n:04}", [], shard) for n, shard in enumerate(shards)]
    for row in ("A", "B"):
        made.append(record(f"subset --row {row}", shards, f"results/{row}.csv"))
        made.append(record(f"train --row {row}", [f"results/{row}.csv", "weights.txt"], f"results/{row}.model"))
    made.append(record("tables", ["results/A.model", "results/B.model"], "results/table.tex"))
    made.append(record("figures", ["results/A.model"], "results/figure.png"))
    return Lineage({}, {Path(f"{n:04}.run.json"): each for n, each in enumerate(made)})


def test_hundreds_of_jobs_share_boxes_that_say_what_they_are(lineage: Lineage) -> None:
    picture = file_svg(lineage, "results/table.tex")
    found = places(picture)
    assert {*found} == {"fog × 300", "subset × 2", "train × 2", "tables", "table.tex", "weights.txt"}
    assert {"airlight", "row: A, B", "shard: 0000, 0001, 0002 ... (300)"} <= {*texts(picture)}
    assert "and 260 more" in picture
    assert "figures" not in picture
    assert "stroke-width='3'" not in picture
    assert found["weights.txt"][0] == found["subset × 2"][0] < found["train × 2"][0]


def test_what_changed_on_disk_is_marked(lineage: Lineage) -> None:
    write_text(Path("results/fog/7.tar"), "other bytes")
    Path("results/A.csv").unlink()
    fresh = Lineage({}, lineage.records)
    picture = file_svg(fresh, "results/table.tex")
    assert texts(picture).count("1 files missing or changed") == 2
    assert picture.count("stroke-width='3'") == 2
    assert re.search(r"results/fog/7\.tar", picture)


def test_a_file_that_nobody_made_is_named(lineage: Lineage) -> None:
    with pytest.raises(FoggyError, match=r"weights\.txt: no run record"):
        file_svg(lineage, "weights.txt")
