"""The subcommands of `foggy` and their parsers, found among the stages."""

import argparse
import importlib
import pkgutil
from pathlib import Path
from types import ModuleType

STAGES = "foggy_synscapes.stages"


def words() -> list[str]:
    """All subcommands, sorted."""
    return sorted(module.name for module in pkgutil.iter_modules([str(Path(__file__).parent / "stages")]))


def parser_of(word: str) -> tuple[ModuleType, argparse.ArgumentParser]:
    """The stage of a subcommand, and the parser of its options.

    Raises ModuleNotFoundError where it needs a package that is not installed.
    """
    stage = importlib.import_module(f"{STAGES}.{word}")
    parser = argparse.ArgumentParser(prog=f"foggy {word}", description=stage.HELP)
    parser.add_argument(
        "--params", type=Path, default=Path("params.yaml"), metavar="FILE", help="params file (default: params.yaml)"
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    stage.arguments(parser)
    return stage, parser
