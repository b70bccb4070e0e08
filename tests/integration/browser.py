"""A headless Chromium, driven over the DevTools protocol; it leaves nothing behind."""

from __future__ import annotations

import base64
import itertools
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import urlopen

from websockets.sync.client import connect

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--remote-debugging-port=0",
)


class Browser:
    """A context manager; ``evaluate`` runs JavaScript in the one page."""

    def __init__(self, width=1440, height=900):
        self.size = width, height
        self.console = []
        self.numbers = itertools.count(1)

    def __enter__(self):
        with ExitStack() as stack:
            self.folder = tempfile.mkdtemp()
            stack.callback(shutil.rmtree, self.folder, ignore_errors=True)
            self.process = subprocess.Popen(
                [CHROMIUM, *FLAGS, f"--user-data-dir={self.folder}", "about:blank"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
            stack.callback(self._kill)
            with urlopen(f"http://127.0.0.1:{self._port()}/json/list", timeout=10) as answer:
                target = next(t for t in json.load(answer) if t["type"] == "page")
            url = target["webSocketDebuggerUrl"]
            self.socket = stack.enter_context(connect(url, max_size=None, compression=None))
            self._prepare()
            self.stack = stack.pop_all()
        return self

    def __exit__(self, *_):
        self.stack.close()

    def _prepare(self):
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        width, height = self.size
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def call(self, method, **params):
        """One DevTools command; events that come meanwhile are kept where they tell of errors."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv(timeout=30))
            if message.get("id") == number:
                assert "error" not in message, message["error"]
                return message["result"]
            self._note(message)

    def evaluate(self, script):
        """The value of an expression, promises awaited."""
        result = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def until(self, script, timeout_s=15.0):
        """The expression's value, once it is true."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            value = self.evaluate(
                f"(() => {{ try {{ return {script} }} catch (e) {{ return null }} }})()"
            )
            if value:
                return value
            time.sleep(0.05)
        raise AssertionError(f"never true: {script}; console: {self.console}")

    def open(self, url):
        self.call("Page.navigate", url=url)
        self.until(
            f"document.readyState === 'complete' && location.host === {urlsplit(url).netloc!r}"
        )

    def reload(self):
        self.call("Page.reload")
        self.until("document.readyState === 'complete'")

    def click(self, x, y):
        """The mouse, in CSS pixels of the page."""
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def picture(self, path):
        """A screenshot as PNG."""
        data = self.call("Page.captureScreenshot", format="png")["data"]
        Path(path).write_bytes(base64.b64decode(data))

    def _note(self, message):
        kind, params = message.get("method"), message.get("params", {})
        if kind == "Runtime.exceptionThrown":
            self.console.append(params["exceptionDetails"].get("exception", params))
        elif kind == "Log.entryAdded" and params["entry"]["level"] == "error":
            if params["entry"]["source"] != "network":  # a server that is away is told of there
                self.console.append(params["entry"]["text"])
        elif kind == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.console.append(params["args"])

    def _port(self):
        end = time.monotonic() + 30
        told = Path(self.folder, "DevToolsActivePort")
        while time.monotonic() < end:
            if told.exists() and (lines := told.read_text().splitlines()):
                return int(lines[0])
            assert self.process.poll() is None, "the browser ended"
            time.sleep(0.05)
        raise AssertionError("the browser does not answer")

    def _kill(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
