"""`foggy networks`: the networks at their published sizes."""

import argparse
import json

HELP = "Show the networks at their published size: parameters, and multiply-adds for an image of 1024 x 512 pixels."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--json", action="store_true", help="print one JSON list instead of lines for people")


def run(args: argparse.Namespace) -> None:
    """Print the catalogue."""
    networks(as_json=args.json)


def networks(as_json: bool) -> None:
    """Print what each network is and costs; counts are whole numbers, not millions."""
    from foggy_synscapes.networks.catalogue import catalogue

    entries = catalogue()
    if as_json:
        print(json.dumps(entries, indent=1))
        return
    for entry in entries:
        print(
            f"{entry['name']} on {entry['backbone']}: {entry['parameters']:,} parameters "
            f"({entry['parameters_without_auxiliary_heads']:,} without heads that only training uses), "
            f"{entry['multiply_adds_1024x512'] / 1e9:.1f} G multiply-adds at 1024 x 512 pixels"
        )
