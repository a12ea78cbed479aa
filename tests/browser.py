"""A headless Chromium, spoken to over pipes: what a page says on its console, asks of the network, and shows."""

import base64
import fcntl
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome-headless-shell")
PATIENCE = 60.0  # seconds
# Chromium reads from descriptor 3 and writes to 4: ours are moved there from where they cannot be in the way.
HIGH = 50
START = "import os, sys; [os.dup2(int(sys.argv[k]), k + 2) for k in (1, 2)]; os.execv(sys.argv[3], sys.argv[3:])"


def program():
    """The browser of this machine, or a skipped test."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    return found or pytest.skip("pages are looked at in Chromium, which this machine does not have")


def _moved(descriptor):
    high = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, HIGH)
    os.close(descriptor)
    return high


class Browser:
    """A page in a browser of its own. `requests` and `complaints` are what it asked for and what went wrong in it."""

    def __init__(self, folder, size=(1000, 700)):
        inward, self.outward = map(_moved, os.pipe())
        self.inward, outward = map(_moved, os.pipe())
        command = [
            program(), "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-extensions",
            "--disable-background-networking", "--remote-debugging-pipe", f"--user-data-dir={folder}",
            f"--window-size={size[0]},{size[1]}", "about:blank",
        ]  # fmt: skip
        self.process = subprocess.Popen(
            [sys.executable, "-c", START, str(inward), str(outward), *command], pass_fds=(inward, outward),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        os.close(inward)
        os.close(outward)
        os.set_blocking(self.inward, False)
        self.buffer, self.number, self.session = b"", 0, None
        self.requests, self.complaints, self.loaded = [], [], False

    def __enter__(self):
        try:
            target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        except (TimeoutError, BrokenPipeError):
            self.__exit__()
            pytest.skip(f"Chromium answered nothing within {PATIENCE:.0f} s, as where processes may not be sandboxed")
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")
        return self

    def __exit__(self, *_):
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        os.close(self.inward)
        os.close(self.outward)

    def ask(self, method, **parameters):
        """The answer to one command."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        message |= {"sessionId": self.session} if self.session else {}
        os.write(self.outward, json.dumps(message).encode() + b"\0")
        return self._until(lambda event: event.get("id") == self.number)["result"]

    def open(self, path):
        """Load a file, and wait until it is there."""
        self.requests.clear()
        self.loaded = False
        self.ask("Page.navigate", url=path.as_uri())
        if not self.loaded:
            self._until(lambda event: event.get("method") == "Page.loadEventFired")

    def value(self, expression):
        """What an expression is, in the page."""
        return self.ask("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def drag(self, begin, end):
        """Press, move and release the mouse."""
        for kind, (x, y) in (("Pressed", begin), ("Moved", end), ("Released", end)):
            self.ask("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, button="left", buttons=1, clickCount=1)

    def picture(self, path):
        """Write what is seen as a PNG."""
        path.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot")["data"]))

    def _until(self, wanted):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            while b"\0" in self.buffer:
                message, self.buffer = self.buffer.split(b"\0", 1)
                event = json.loads(message)
                self._noted(event)
                if wanted(event):
                    return event
            try:
                self.buffer += os.read(self.inward, 1 << 20)
            except BlockingIOError:
                time.sleep(0.01)
        raise TimeoutError(f"the browser has not answered in {PATIENCE:g} s")

    def _noted(self, event):
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif method == "Page.loadEventFired":
            self.loaded = True
        elif method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
            self.complaints.append(json.dumps(parameters)[:500])
