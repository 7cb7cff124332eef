"""`foggy gallery`: all figures and tables of a finished run on one page, to be read from top to bottom."""

import argparse
import base64
import html
import re
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import read_bytes
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params, load
from foggy_synscapes.results import RESULTS
from foggy_synscapes.steps import of

HELP = "Put all tables and figures that are made on one page for the browser, with the command behind each."

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Tables and figures</title><style>
/* No script, font or picture from elsewhere: the page is whole by itself. */
body {{ font: 14px sans-serif; margin: 1em; color: #111; }}
img {{ max-width: 100%; height: auto; }}
section {{ overflow-x: auto; border-bottom: 1px solid #ddd; }}
table {{ border-collapse: collapse; font: 12px sans-serif; font-variant-numeric: tabular-nums; }}
th, td {{ padding: 0.2em 0.4em; border-bottom: 1px solid #ddd; white-space: nowrap; text-align: right; }}
th {{ font-weight: normal; text-align: left; }}
</style></head>
<body>
<h1>Tables and figures</h1>
<nav>{links}</nav>
{sections}
</body></html>
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("--out", type=Path, default=Path(RESULTS, "gallery.html"), metavar="FILE", help="page to write")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    count = gallery(load(args.params), args.out)
    print(f"{args.out}: {count} tables and figures")


def gallery(params: Params, out: Path) -> int:
    """Write the page; what is not made is left out. Returns how many tables and figures it shows.

    Raises FoggyError if there is none.
    """
    steps = [*of("tables"), *of("figures")]
    jobs = [Job(step, params, values) for step in steps for values in step.all_values(params)]
    sections: list[tuple[str, str]] = []
    for job in jobs:
        shown = [path for path in job.outputs() if path.suffix in (".html", ".png") and path.is_file()]
        # Tables of the paper's rows alone are those of all rows again.
        if not shown or not job.step.default:
            continue
        name = shown[0].stem
        made = f"<p>{html.escape(job.step.text)}</p>" if shown[0].suffix == ".png" else ""
        sections.append((name, f"{_content(shown[0])}{made}<p><code>{html.escape(' '.join(job.command))}</code></p>"))
    if not sections:
        raise FoggyError(f"{RESULTS}: no table or figure is made yet. Run `snakemake --cores 2` first.")
    links = " · ".join(f'<a href="#{name}-{number}">{name}</a>' for number, (name, _) in enumerate(sections))
    parts = (f'<section id="{name}-{number}">\n{text}\n</section>' for number, (name, text) in enumerate(sections))
    write_text(out, PAGE.format(links=links, sections="\n".join(parts)))
    return len(sections)


def _content(path: Path) -> str:
    """A table's page without its head, or an image, as part of another page."""
    data = read_bytes(path, "result")
    if path.suffix == ".html":
        return re.sub(r".*<body>|</body>.*", "", data.decode(), flags=re.DOTALL)
    return (
        f'<h2>{path.stem}</h2>\n<img alt="{path.stem}" src="data:image/png;base64,{base64.b64encode(data).decode()}">'
    )
