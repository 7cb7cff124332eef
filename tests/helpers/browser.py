"""A headless Chromium, driven through a pipe by its DevTools protocol; nothing but the standard library is needed."""

import base64
import json
import os
import shutil
import subprocess
import tempfile
from collections import deque
from pathlib import Path
from types import TracebackType
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome", "chrome-headless-shell")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-extensions", "--hide-scrollbars", "--mute-audio",
    "--enable-unsafe-swiftshader", "--remote-debugging-pipe",
)  # fmt: skip
WHY_NOT = "no Chromium: none of " + ", ".join(NAMES) + " is on PATH, and CHROMIUM names none"


def found() -> str | None:
    """The Chromium that CHROMIUM names, or the first on PATH; None where there is none."""
    named = os.environ.get("CHROMIUM")
    return next(filter(None, map(shutil.which, [named] if named else NAMES)), None)


class Browser:
    """One page of a headless Chromium.

    size : of the window in CSS pixels; touch : as a phone has it
    """

    def __init__(self, size: tuple[int, int] = (1500, 1000), touch: bool = False) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="browser")
        to_it, self._to = os.pipe()
        self._from, from_it = os.pipe()
        # Chromium reads commands from descriptor 3 and writes answers to 4; each message ends with a zero byte.
        arguments = " ".join([*FLAGS, f"--user-data-dir={self._folder.name}", "about:blank"])
        shell = f'exec "$BROWSER" {arguments} 3<&{to_it} 4>&{from_it} 2>/dev/null'
        self._process = subprocess.Popen(
            ["bash", "-c", shell],
            pass_fds=(to_it, from_it),
            env={**os.environ, "BROWSER": found() or ""},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
        )
        os.close(to_it)
        os.close(from_it)
        self._rest, self._count, self._session = b"", 0, ""
        self.events: deque[dict[str, Any]] = deque(maxlen=1000)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.resize(*size, touch)

    def resize(self, width: int, height: int, touch: bool = False) -> None:
        """Give the window another size."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """One command of the protocol; RuntimeError where the browser refuses it."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def _next(self) -> dict[str, Any]:
        parts = [self._rest]
        while b"\0" not in parts[-1]:
            piece = os.read(self._from, 1 << 20)
            if not piece:
                raise RuntimeError("the browser ended")
            parts.append(piece)
        message, _, self._rest = b"".join(parts).partition(b"\0")
        return json.loads(message)

    def open(self, path: Path, fragment: str = "") -> None:
        """Open a page from disk, and wait until it is shown."""
        self.events.clear()
        self.call("Page.navigate", url=path.resolve().as_uri() + fragment)
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._next())
        self.run("await view.ready")

    def run(self, script: str) -> Any:
        """The value of an expression, or of a function's body with `return`, which may await."""
        body = script if "return " in script else f"return ({script});"
        answer = self.call(
            "Runtime.evaluate", expression=f"(async () => {{{body}}})()", awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description"))
        return answer["result"].get("value")

    def bytes(self, script: str) -> bytes:
        """The bytes of an array of an expression."""
        return base64.b64decode(
            self.run(
                f"const found = {script}; let text = '';"
                "for (let n = 0; n < found.length; n += 32768)"
                " text += String.fromCharCode(...found.subarray(n, n + 32768));"
                "return btoa(text);"
            )
        )

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width and height of an element in the window."""
        found = self.run(
            f"const box = document.querySelector('{selector}').getBoundingClientRect();"
            "return [box.left, box.top, box.width, box.height];"
        )
        return found[0], found[1], found[2], found[3]

    def mouse(self, kind: str, x: float, y: float) -> None:
        """Press, move or release the left button."""
        names = {"press": "mousePressed", "move": "mouseMoved", "release": "mouseReleased"}
        self.call("Input.dispatchMouseEvent", type=names[kind], x=x, y=y, button="left", buttons=1, clickCount=1)

    def click(self, selector: str, x: float = 0.5, y: float = 0.5) -> None:
        """Click an element at a share of its size."""
        self.run(f"return void document.querySelector('{selector}').scrollIntoView({{block: 'nearest'}})")
        left, top, width, height = self.box(selector)
        for kind in ("move", "press", "release"):
            self.mouse(kind, left + x * width, top + y * height)

    def drag(self, selector: str, shares: list[float], within: str) -> None:
        """Drag an element by the mouse to shares of another one's width, one after the other."""
        left, top, width, height = self.box(selector)
        y = top + height / 2
        self.mouse("move", left + width / 2, y)
        self.mouse("press", left + width / 2, y)
        start, _, whole, _ = self.box(within)
        for share in shares:
            self.mouse("move", start + share * whole, y)
        self.mouse("release", start + shares[-1] * whole, y)

    def touch(self, selector: str, shares: list[float], within: str) -> None:
        """Drag an element by a finger."""
        left, top, width, height = self.box(selector)
        start, _, whole, _ = self.box(within)
        y = top + height / 2
        point = [{"x": left + width / 2, "y": y}]
        self.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=point)
        for share in shares:
            point = [{"x": start + share * whole, "y": y}]
            self.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=point)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def key(self, key: str, shift: bool = False) -> None:
        """Press and release a key."""
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            more = text if kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0, **more)

    def picture(self, path: Path, whole: bool = False) -> None:
        """Write what the window shows, or the whole page, as a PNG."""
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))

    def complaints(self) -> list[str]:
        """Errors of the page, and what it asked the network for."""
        self.run("0")
        found = []
        for event in self.events:
            params = event.get("params", {})
            if event.get("method") == "Runtime.exceptionThrown":
                found.append(str(params["exceptionDetails"]))
            if event.get("method") == "Log.entryAdded" and params["entry"]["level"] == "error":
                found.append(params["entry"]["text"])
            if event.get("method") == "Network.requestWillBeSent":
                url = params["request"]["url"]
                found += [url] if not url.startswith(("file:", "data:", "blob:")) else []
        return found

    def close(self) -> None:
        """End the browser."""
        self._process.terminate()
        self._process.wait(20)
        os.close(self._to)
        os.close(self._from)
        self._folder.cleanup()

    def __enter__(self) -> "Browser":
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self.close()
