"""The pages of docs/ that are made are as they would be made now, and the README stays short."""

import re
import runpy
from pathlib import Path

import pytest

from foggy_synscapes.tables import published
from foggy_synscapes.tables.table import MEAN

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


@pytest.mark.parametrize("name", ["commands", "api"])
def test_a_page_that_is_made_from_the_code_is_current(name: str) -> None:
    made = runpy.run_path(str(DOCS / f"make_{name}.py"))["page"]()
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == made, "run `make schema`"


def test_the_picture_of_the_published_tables_holds_their_means() -> None:
    drawn = (DOCS / "images/published.svg").read_text(encoding="utf-8")
    assert runpy.run_path(str(DOCS / "make_table.py"))["picture"]().decode() == drawn, "run `make status`"
    texts = re.findall(r"<text [^>]*>([^<]*)</text>", drawn)
    printed = [text for text in texts if re.fullmatch(r"\d+\.\d", text)]
    means = [str(mean) for name in published.TEST_SETS for mean in published.load(name)[MEAN]]
    assert sorted(printed) == sorted(means)


def test_the_readme_is_one_look_long() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120


def test_every_page_is_in_the_list_of_pages() -> None:
    """Sphinx stops at a page that no list names; here it is said without Sphinx."""
    listed = re.findall(r"^(\w[\w-]*)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted(path.stem for path in DOCS.glob("*.md") if path.stem != "index")


@pytest.mark.parametrize("path", [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))])
def test_links_between_files_lead_somewhere(path: Path) -> None:
    """Anchors too: a heading in small letters, without punctuation, with hyphens for spaces."""
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]+))?\)", path.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        file = path.parent / target if target else path
        assert file.exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            slugs = [re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings]
            assert anchor in slugs, f"{target}#{anchor}"


def test_the_files_of_versions_and_of_hashes_agree() -> None:
    """PyTorch has no hash: which of its builds is installed depends on the index."""
    hashed = (ROOT / "requirements-hashes.lock").read_text(encoding="utf-8")
    pinned = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    versions = [dict(re.findall(r"^([\w.-]+)==([^\s;]+)", text, re.MULTILINE)) for text in (hashed, pinned)]
    assert {name: versions[0].get(name) for name in versions[1]} == versions[1] | {"torch": None}
    entries = re.split(r"^(?=[\w.-]+==)", hashed, flags=re.MULTILINE)[1:]
    assert all("--hash=sha256:" in entry for entry in entries)
