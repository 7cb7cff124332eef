"""The documentation site: `make docs` builds it by Sphinx into build/docs, to be opened from disk or served.

README.md is the first page, and other texts of the top folder are pages too. Each text exists once, and its links
hold both on a code host and in the site: here `docs/fog.md` in a text of the top folder becomes `fog.md`, and
`../CHANGELOG.md` in a page of docs/ becomes `changelog.md`. Other files that a page links to are copied into it.
"""

import re
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[1]
TOP = {"index": "README.md", "changelog": "CHANGELOG.md", "contributing": "CONTRIBUTING.md"}
"""Pages that are made of texts of the top folder."""
LINK = re.compile(r"(?<=\]\()([^)#\s]+)(?=[)#])")

project = "Foggy Synscapes"
author = project_copyright = "Foggy Synscapes contributors"
extensions = ["myst_parser", "sphinx_copybutton"]
myst_heading_anchors = 4
exclude_patterns = ["requirements.in"]
html_theme = "furo"
html_title = project
html_copy_source = False
html_show_sourcelink = False
# Examples of code are shell, Python, YAML, JSON and plain text, each named where it is not plain.
highlight_language = "none"


def put_in_texts_of_the_top_folder(_app: Sphinx, page: str, source: list[str]) -> None:
    """Put a text of the top folder before what its page in docs/ holds, and rewrite links."""
    text = source[0]
    if page in TOP:
        # Pages have a title already; what is left below README's text is the list of pages.
        text = (ROOT / TOP[page]).read_text(encoding="utf-8") + "\n" + text
    source[0] = LINK.sub(lambda match: _in_site(match[1], from_top=page in TOP), text)


def _in_site(link: str, from_top: bool) -> str:
    """Where a link of the repository leads in the site, whose pages lie all in one folder."""
    if "://" in link or link.startswith("mailto:"):
        return link
    path = Path(link.removeprefix("../")) if link.startswith("../") or from_top else Path("docs", link)
    for page, text in TOP.items():
        if path == Path(text):
            return f"{page}.md"
    return path.relative_to("docs").as_posix() if path.is_relative_to("docs") else f"../{path.as_posix()}"


def setup(app: Sphinx) -> None:
    """What Sphinx calls."""
    app.connect("source-read", put_in_texts_of_the_top_folder)
