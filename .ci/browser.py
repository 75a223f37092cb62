"""A headless Chromium, driven over a pipe by the DevTools protocol: standard library only."""

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def find():
    """The browser's program: the one that BMV_BROWSER names, else the first on the PATH; None without any."""
    named = os.environ.get("BMV_BROWSER")
    return named or next((found for name in NAMES if (found := shutil.which(name))), None)


class Failed(Exception):
    """The browser refused, or took too long."""


class Browser:
    """A running browser. `events` holds what it said since they were last read."""

    def __init__(self, program):
        self.profile = tempfile.mkdtemp(prefix="bmv-browser-")
        to_browser, self.to = os.pipe()
        self.of, of_browser = os.pipe()

        def descriptors():
            # The protocol's: 3 to read from, 4 to write to. Copies first, so that neither takes the other's place.
            one, two = os.dup(to_browser), os.dup(of_browser)
            os.dup2(one, 3)
            os.dup2(two, 4)

        arguments = [
            program, "--headless=new", "--remote-debugging-pipe", f"--user-data-dir={self.profile}", "--no-first-run",
            "--disable-gpu", "--hide-scrollbars", "--disable-background-networking", "--disable-component-update",
            "--disable-dev-shm-usage", "about:blank",
        ]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            arguments.insert(1, "--no-sandbox")
        self.process = subprocess.Popen(
            arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=descriptors, close_fds=False,
            start_new_session=True,
        )
        os.close(to_browser)
        os.close(of_browser)
        self.number, self.rest, self.events, self.session = 0, b"", [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def close(self):
        """Ends the browser and removes its profile."""
        try:
            self.session = None
            self.call("Browser.close", timeout=5)
            self.process.wait(5)
        except (Failed, OSError, subprocess.TimeoutExpired):
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        os.close(self.to)
        os.close(self.of)
        shutil.rmtree(self.profile, ignore_errors=True)

    def messages(self, timeout):
        """What the browser says next, or nothing within the time."""
        ready, _, _ = select.select([self.of], [], [], max(timeout, 0))
        if ready:
            read = os.read(self.of, 1 << 20)
            if not read:
                raise Failed("the browser ended")
            *whole, self.rest = (self.rest + read).split(b"\0")
            return [json.loads(message) for message in whole]
        return []

    def call(self, method, timeout=60, **parameters):
        """The answer to a call of the protocol."""
        self.number += 1
        own = self.number
        message = {"id": own, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]
        until, answer = time.monotonic() + timeout, None
        while answer is None:
            if time.monotonic() > until:
                raise Failed(f"{method} took longer than {timeout} s")
            for said in self.messages(until - time.monotonic()):
                if said.get("id") == own:
                    answer = said
                elif "method" in said:
                    self.events.append(said)
        if "error" in answer:
            raise Failed(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def recent_events(self):
        """The events since they were last read."""
        events, self.events = self.events, []
        return events

    def open(self, url, timeout=60):
        """Opens an address and waits until it is loaded."""
        self.recent_events()
        answer = self.call("Page.navigate", url=url)
        if answer.get("errorText"):
            raise Failed(f"{url}: {answer['errorText']}")
        until = time.monotonic() + timeout
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            if time.monotonic() > until:
                raise Failed(f"{url} was not loaded within {timeout} s")
            self.events += [said for said in self.messages(1) if "method" in said]

    def evaluate(self, expression, timeout=60):
        """The value of a JavaScript expression; promises are awaited."""
        answer = self.call(
            "Runtime.evaluate", timeout, expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise Failed(details.get("exception", {}).get("description") or details["text"])
        return answer["result"].get("value")

    def size(self, width, height):
        """Sets the size of the window, px; narrow ones are phones."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def media(self, kind="screen", scheme="light"):
        """Sets what the page is shown on, and the colours that its reader prefers."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.call("Emulation.setEmulatedMedia", media=kind, features=features)

    def picture(self, path, whole=False):
        """Keeps a picture of the window, or of the whole page, as PNG."""
        answer = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(answer["data"]))

    def printed(self, path):
        """Prints the page as PDF."""
        answer = self.call("Page.printToPDF", 120, preferCSSPageSize=True, printBackground=True)
        path.write_bytes(base64.b64decode(answer["data"]))
