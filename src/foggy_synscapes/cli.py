"""The command `foggy`: finds the word, lets its stage parse the rest, and turns errors into one message."""

import os
import sys
import textwrap

from foggy_synscapes import __version__, commands
from foggy_synscapes.errors import UNFORESEEN, FoggyError, UsageError
from foggy_synscapes.io import lock

# Word, module below foggy_synscapes.stages, what it does. The first group is the pipeline, in its order.
PIPELINE = {
    "scenes": "render the stand-in data in the real layouts, and list what each dataset holds",
    "filter": "keep frames by their metadata",
    "complete": "complete depth from stereo, and refine its transmittance",
    "fog": "estimate the airlight and render fog; alone: fog on any RGB and depth",
    "subset": "list the images and labels that a row trains on",
    "train": "train or fine-tune a network on a list",
    "evaluate": "score a model on a test set; alone: score any PNG predictions",
    "tables": "make the mIoU tables (CSV, LaTeX, Markdown); alone: the published ones",
    "figures": "draw the figures",
    "view": "make pages to look at predictions; alone: one frame in fog of any density",
}
TOOLS = {
    "atlas": "score fog models against path tracing: which one is enough",
    "adopt": "carry a clone from one engine to the other",
    "card": "write a model card of a trained model",
    "clean": "list and remove results that the params do not ask for any more",
    "completion": "print what lets a shell complete these commands and their options",
    "code": "write what counts of the code of each job, for DVC",
    "croissant": "describe foggy images that were made, for tools that load datasets",
    "export": "write a trained model as one file that runs without this project",
    "gallery": "put all tables and figures that are made on one page",
    "stability": "check the numbers of each arithmetic at the extremes of their inputs",
    "tradeoff": "weigh what cheaper arithmetic saves against what it changes",
    "networks": "show the networks at their published size",
    "params": "print a params file complete, with units and sources; check it",
    "plan": "say what a target runs, reads and costs, before anything starts",
    "steps": "show the table of steps, or make dvc.yaml from it",
    "trace": "show what a result was made from, down to the raw data",
    "unpack": "unpack fog shards into folders",
    "verify": "hash results again and compare with their run records",
    "weights": "import public weights to start from or to score",
}

EXTRAS = {
    "train": ("torch", "safetensors"),
    "export": ("onnx", "onnxruntime", "onnxscript"),
    "matlab": ("h5py",),
    "crate": ("rocrate",),
}
"""Packages beyond fog and scores by the extra that brings them; all others come with `experiment`."""


def main(arguments: list[str] | None = None) -> int:
    """Run one command line; return 0 for good, 1 where the work failed, 2 where the call was wrong."""
    arguments = sys.argv[1:] if arguments is None else arguments
    words = {**PIPELINE, **TOOLS}
    word = arguments[0] if arguments else "--help"
    if word in ("-h", "--help", "help"):
        print(_explanation())
        return 0
    if word == "--version":
        print(f"foggy {__version__}")
        return 0
    if word not in words:
        return _fail(f"no such command; there are {', '.join(words)}. Try `foggy --help`.", word, 2)
    os.environ["MPLBACKEND"] = "agg"  # drawings go to files; that of a notebook or another machine may not exist here
    try:
        stage, parser = commands.parser_of(word)
    except ModuleNotFoundError as error:
        return _fail(_not_installed(error), word)
    try:
        options = parser.parse_args(arguments[1:])
    except SystemExit as stop:
        return int(stop.code or 0)
    try:
        # What has no --out writes to results/, where the engines do; but scores of anyone's predictions are printed.
        to_results = getattr(options, "out", None) is None and getattr(options, "predictions", None) is None
        held = lock.join() if word in PIPELINE and to_results else None
        stage.run(options)
        if held is not None:
            held.close()
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of our output (such as `head`) has gone; that is its good right. What is left goes nowhere, also
        # at the interpreter's end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        return _fail("interrupted; what is finished is kept, run the same command to go on", word)
    except ModuleNotFoundError as error:
        if options.debug:
            raise
        return _fail(_not_installed(error), word)
    except (FoggyError, MemoryError, *UNFORESEEN, OSError) as error:
        if options.debug:
            raise
        return _fail(_message(error), word, 2 if isinstance(error, UsageError) else 1)
    return 0


def _not_installed(error: ModuleNotFoundError) -> str:
    """Which extra brings a package that is missing: the bare installation has fog and scores alone."""
    package = (error.name or str(error)).partition(".")[0]
    if package == "foggy_synscapes":
        return f"{error}. The installation is not whole: install it again."
    extra = next((extra for extra, packages in EXTRAS.items() if package in packages), "experiment")
    return f"needs {package}, which is not installed. Install it: pip install 'foggy-synscapes[{extra}]'"


def _message(error: Exception) -> str:
    if isinstance(error, FoggyError):
        return str(error)
    if isinstance(error, MemoryError):
        return f"not enough memory: {error}. Use fewer --jobs, or smaller shards or batches."
    # No input should get here: a person still gets one message, and --debug shows where it came from.
    return f"{type(error).__name__}: {error}. This message should name a file or key; --debug shows where it arose."


def _fail(message: str, word: str, status: int = 1) -> int:
    print(f"foggy {word}: {message}", file=sys.stderr)
    return status


def _explanation() -> str:
    lines = [
        "foggy COMMAND [options]: fog on street scenes, networks trained on it, and the tables of their scores.",
        "",
        "The whole experiment:    snakemake --cores 2    or    dvc repro",
        "Fog on your own frames:  foggy fog --rgb IMAGES --depth DEPTHS --camera camera.json --beta 0.01 --out DIR",
        "",
        "Steps of the experiment, in order:",
        *(_entry(word, text) for word, text in PIPELINE.items()),
        "",
        "Tools:",
        *(_entry(word, text) for word, text in TOOLS.items()),
        "",
        "foggy COMMAND --help shows its options and their units.",
    ]
    return "\n".join(lines)


def _entry(word: str, text: str) -> str:
    return textwrap.fill(text, 100, initial_indent=f"  {word:<11}", subsequent_indent=" " * 13)
