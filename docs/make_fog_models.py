"""Write docs/fog_models.md and its picture: the models with their values, and what the atlas found.

Run by `make fog_models` after `foggy atlas`; numbers are those of results/atlas and of the models' own settings.
"""

import shutil
from dataclasses import fields
from pathlib import Path

import pandas as pd

from foggy_synscapes.fog import ladder
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.fog.models.settings import allowed
from foggy_synscapes.io.atomic import write_text

ATLAS, PICTURE = Path("results/atlas"), Path("docs/images/fog_models.png")
ORDER = ("none", "homogeneous", "layered", "heterogeneous", "surround", "auto")
SAME = {"albedo": 1.0, "asymmetry": 0.85, "height": 0.0, "airlight": "estimated"}
LINEAR, SERIES, DIMMED = "homogeneous, in linear light", "Narasimhan-Nayar series", ladder.DIMMED


def main() -> None:
    """Write the page and the picture."""
    errors, held = pd.read_csv(ATLAS / "atlas.csv"), pd.read_csv(ATLAS / "held.csv")
    slabs = pd.read_csv("src/foggy_synscapes/atlas/slabs.csv")
    text = (ATLAS / "atlas.md").read_text(encoding="utf-8")
    caption, *parts = text.split("\n## ")
    sections = {part.partition("\n")[0]: part.partition("\n")[2].strip() for part in parts}
    counted = "How often each model was the cheapest within a tolerance"
    enough = sections.pop(counted).split("\n\nOn frames")[0]
    main_ = errors[(errors["frame"] % 2 == 1) & (errors["beta"] == 0.02)]
    for key, value in SAME.items():
        main_ = main_[main_[key] == value]

    def off(model: str, outside: str) -> str:
        return f"{main_[(main_['model'] == model) & (main_['surround'] == outside)]['mean'].mean():.0f}"

    def of_layers(model: str) -> str:
        here = errors[(errors["height"] > 0) & (errors["model"] == model)]
        return " and ".join(f"{value:.0f}" for value in here.groupby("height")["mean"].mean())

    worst = ((slabs["traced"] - slabs["ordinates"]) / slabs["standard_error"]).abs().max()
    parts_of = (
        f"at a beta of 0.02 / m the standard fog is {off('homogeneous', 'open')} to {off('homogeneous', 'ground')}",
        "levels from path tracing, as its airlight is the sky's alone; a blurred copy of the scene in the airlight",
        f"(`surround`) brings that to {off('surround', 'open')} to {off('surround', 'ground')}, a dimmed",
        f"airlight, at no cost, to {off(DIMMED, 'open')} to {off(DIMMED, 'ground')}.",
    )
    conclusion = " ".join(parts_of)
    names = {"open": "open", "ground": "ground"}
    page = (
        Path("docs/fog_models.md.in")
        .read_text(encoding="utf-8")
        .format(
            frames=errors["frame"].nunique(),
            **{f"hom_{name}": off("homogeneous", name) for name in names},
            **{f"lin_{name}": off(LINEAR, name) for name in names},
            **{f"none_{name}": off("none", name) for name in names},
            **{f"dim_{name}": off(DIMMED, name) for name in names},
            **{f"series_{name}": off(SERIES, name) for name in names},
            **{f"share_{name}": ladder.SHARE[name] for name in names},
            layered=of_layers("layered"),
            layered_surround=of_layers("surround"),
            conclusion=conclusion,
            rows="above with open surround, below over ground",
            models=_table(["model", "what it assumes"], [[name, MODELS[name].text] for name in ORDER]),
            values=_table(["model", "value", "unit", "default", "range", "meaning"], _values()),
            rungs=", ".join(f"`{name}`" for name in ladder.RUNGS),
            block=caption.split("blocks of ")[1].split(" x ")[0],
            noise=caption.split("of a block ")[1].split(" ")[0],
            bytes=round(Path("src/foggy_synscapes/atlas/reference.npz").stat().st_size / 1000),
            slabs=f"{worst:.1f}",
            slab_count=len(slabs),
            tables="\n\n".join(f"**{head}**\n\n{table}" for head, table in sections.items()),
            enough=enough,
            held=f"{(held['error'] <= held['bound']).mean():.0%}",
            held_count=len(held),
        )
    )
    write_text("docs/fog_models.md", page)
    shutil.copyfile(ATLAS / "atlas.png", PICTURE)
    print(conclusion)


def _values() -> list[list[str]]:
    lines = []
    for name in ORDER:
        for each in fields(MODELS[name].settings):
            if each.name == "airlight" and name != ORDER[0]:
                continue
            shown = "fitted" if each.default is None else str(each.default)
            which = "every model" if each.name == "airlight" else name
            range_ = allowed(each.metadata) or "or grey, or RED/GREEN/BLUE"
            lines.append([which, f"`{each.name}`", each.metadata["unit"], shown, range_, each.metadata["meaning"]])
    return lines


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))


if __name__ == "__main__":
    main()
