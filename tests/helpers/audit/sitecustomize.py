"""Python starts with this module where its folder is on PYTHONPATH: it writes down what the process reads and writes.

One line of JSON for each event, in FOGGY_AUDIT/PID.jsonl, of this process and of those that it forks or starts.
Only Python's own opening of files is seen, not that of libraries written in C.
"""

import atexit
import json
import os
import sys

EVENTS = {
    "open": "file",
    "os.rename": "written",
    "os.listdir": "folder",
    "os.scandir": "folder",
    "socket.connect": "network",
    "socket.getaddrinfo": "network",
    "socket.bind": "network",
    "urllib.Request": "network",
    "subprocess.Popen": "process",
    "os.system": "process",
}
PATHS = ("file", "folder", "written")
WRITING = os.O_WRONLY | os.O_RDWR
writers = {}


def write(kind, value):
    """Append an event to the file of this process, which after a fork is another one."""
    process = os.getpid()
    if process not in writers:
        writers[process] = None  # what opens the file is an event, too
        path = os.path.join(os.environ["FOGGY_AUDIT"], f"{process}.jsonl")
        writers[process] = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    if writers[process] is not None:
        os.write(writers[process], (json.dumps([kind, value]) + "\n").encode())


def hook(event, arguments):
    """Write down an event that reads or writes something."""
    if event not in EVENTS or (event == "open" and not isinstance(arguments[0], (str, bytes))):
        return
    if event in ("socket.connect", "socket.bind") and isinstance(arguments[1], (str, bytes)):
        return  # a path: between processes of one machine, as those of a data loader
    kind = "written" if event == "open" and _writes(arguments) else EVENTS[event]
    value = arguments[0] if kind in PATHS else arguments[:2]
    if event == "os.rename":
        value = arguments[1]
    if isinstance(value, bytes):
        value = os.fsdecode(value)
    if kind in PATHS:
        value = os.path.abspath(value) if isinstance(value, str) else os.getcwd()
        if value.startswith(os.environ["FOGGY_AUDIT"]):
            return
    write(kind, value if isinstance(value, str) else repr(value))


def _writes(arguments):
    _, mode, flags = arguments
    if isinstance(mode, str):
        return any(letter in mode for letter in "wxa")
    return bool((flags or 0) & WRITING)


def modules():
    """At the end, the modules of this project that were imported."""
    for name, module in sorted(sys.modules.items()):
        if name.split(".")[0] == "foggy_synscapes" and getattr(module, "__file__", None):
            write("module", os.path.abspath(module.__file__))


if "FOGGY_AUDIT" in os.environ:
    sys.addaudithook(hook)
    atexit.register(modules)
