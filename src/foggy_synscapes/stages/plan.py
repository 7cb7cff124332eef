"""plan: what a target will run, need and cost, before anything starts."""

import argparse
import json
import math
import sys

from foggy_synscapes.errors import UsageError
from foggy_synscapes.params import Params, load
from foggy_synscapes.planning.asked import TARGETS
from foggy_synscapes.planning.checks import problems
from foggy_synscapes.planning.plan import Plan, plan

HELP = (
    "Say what a target runs, reads and costs, whether parts are made already or not: jobs by word, trainings, clear "
    "frames of Synscapes and foggy images, bytes on disk, multiply-adds. Nothing is run and no dataset is needed; what "
    "a run would lack is warned of. Disk: 1.16 bytes for a pixel of a foggy image (measured on real frames; 500 bytes "
    "an image where fog.render is on_the_fly), 4 for each weight of a model, 0.02 for a pixel of a prediction, 4 for a "
    "pixel of a drawn frame; without snapshots of trainings under way, DVC's cache and the datasets themselves. "
    "Multiply-adds: of each network as the params shape it, in proportion to pixels, a step backwards as two forwards; "
    "images of Foggy Driving as if all had 1280 x 960 pixels."
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument(
        "target",
        nargs="*",
        default=["all"],
        metavar="TARGET",
        help=f"{', '.join(TARGETS)}, a word such as fog, the name of a step, or a path below results/ (default: all)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table for people")
    parser.add_argument(
        "--images-per-second",
        action="append",
        default=[],
        metavar="NETWORK=RATE",
        help="training images a second that you measured for a network: gives its hours on one device, validation and "
        "evaluation as if they made as many multiply-adds a second; may be repeated",
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    params = load(args.params)
    rates = _rates(params, args.images_per_second)
    found, jobs = plan(params, args.target)
    warnings = [*params.warnings(), *problems(params, jobs)]
    warnings += [f"{name}: nobody says how many images it has; its evaluation is not counted" for name in found.unknown]
    for warning in warnings:
        print(f"{args.params}: warning: {warning}", file=sys.stderr)
    if args.json:
        document = found.document()
        hours = {network: _hours(found, network, rate) for network, rate in rates.items()}
        print(json.dumps(document | ({"hours": hours} if hours else {}), indent=1))
    else:
        print("\n".join(_lines(found, rates)))


def _rates(params: Params, given: list[str]) -> dict[str, float]:
    rates = {}
    for text in given:
        network, _, number = text.partition("=")
        try:
            rates[network] = float(number)
        except ValueError:
            rates[network] = math.nan
        if not 0 < rates[network] < math.inf:
            raise UsageError(f"--images-per-second {text}: expected NETWORK=RATE with a rate above 0, as bisenet=12.5")
        if network not in params.train.networks:
            raise UsageError(f"--images-per-second {text}: the params train {', '.join(params.train.networks)}")
    return rates


def _hours(plan: Plan, network: str, rate: float) -> float:
    """Hours of a network on one device at so many training images a second."""
    images = sum(each["images_seen"] for each in plan.trainings if each["network"] == network)
    spent = plan.by_network.get(network)
    if spent is None or images == 0:
        return 0.0
    return images / rate / 3600 * sum(spent.values()) / spent["training"]


def _lines(plan: Plan, rates: dict[str, float]) -> list[str]:
    rows = [(word, f"{count:,} jobs") for word, count in plan.jobs.items()]
    rows.append(("", f"{sum(plan.jobs.values()):,} jobs in all"))
    rows.append(("datasets", ", ".join(f"{name} ({folder})" for name, folder in plan.datasets.items()) or "none"))
    rows.append(("frames", f"{plan.frames:,} of Synscapes, of which {plan.foggy_images:,} foggy images are made"))
    for network, spent in plan.by_network.items():
        own = [each for each in plan.trainings if each["network"] == network]
        images, looks = (sum(each[key] for each in own) for key in ("images_seen", "validations"))
        rows.append((network, f"{len(own)} trainings, {images:,} images seen, {looks:,} validations"))
        if network in rates:
            rows.append(("", f"{_hours(plan, network, rates[network]):,.1f} h at {rates[network]:g} training images/s"))
        rows.append(
            ("", ", ".join(f"{kind} {cost / 1e15:,.3g}" for kind, cost in spent.items()) + " x 10^15 multiply-adds")
        )
    rows.append(("multiply-adds", f"{sum(plan.multiply_adds.values()) / 1e15:,.4g} x 10^15"))
    rows.append(("disk", f"{plan.disk_bytes / 1e9:,.3g} GB"))
    return [f"{name:<14}{text}" for name, text in rows]
