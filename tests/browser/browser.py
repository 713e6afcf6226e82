"""A real Chromium without a screen, a real padr-monitor and real peers: what the browser tests share.

Usage of a test: NAME.py PADR_MONITOR PADR_PEER FOLDER_FOR_SCREENSHOTS [unittest arguments]

Everything that waits has a bound. Where there is no Chromium, no driver or no Selenium, or Chromium does not start, a
test is skipped (exit code 77) and says why; it never passes without having looked.
"""

import base64
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

SKIPPED = 77
DISTRIBUTION = "/usr/bin/python3"  # knows the distribution's Selenium, whatever other Python comes first

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.service import Service
except ImportError:
    again = "PADR_BROWSER_AGAIN" not in os.environ and os.path.realpath(sys.executable) != os.path.realpath(DISTRIBUTION)
    if again and os.path.exists(DISTRIBUTION):
        os.environ["PADR_BROWSER_AGAIN"] = "1"
        os.execv(DISTRIBUTION, [DISTRIBUTION, "-B", *sys.argv])
    print("SKIPPED: no Selenium for Python here (package python3-selenium)")
    sys.exit(SKIPPED)

if len(sys.argv) < 4:
    sys.exit(f"usage: {sys.argv[0]} PADR_MONITOR PADR_PEER FOLDER_FOR_SCREENSHOTS")
MONITOR, PEER, PICTURES = sys.argv.pop(1), sys.argv.pop(1), sys.argv.pop(1)

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "e2e"))
from waiting import PATIENCE  # noqa: E402
from waiting import wait_until as wait  # noqa: E402


class Program:
    """A running program. Its output is read by a thread, so that it never blocks on a full pipe."""

    started = []

    def __init__(self, *command):
        Program.started.append(self)
        self.command = [str(c) for c in command]
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, errors="replace")  # fmt: skip
        self.lines = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))

    def wait_for(self, pattern):
        def look():
            found = [m for m in (re.search(pattern, line) for line in list(self.lines)) if m]
            if not found and self.process.poll() is not None:
                raise AssertionError(f"{self.command} ended: " + "\n".join(self.lines))
            return found[0] if found else None

        return wait(look, f"a line like {pattern!r} of {self.command}")

    def stop(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)

    def end(self, how=signal.SIGTERM):
        """Stops it; its exit code."""
        self.stop(how)
        return self.ended()

    def ended(self):
        try:
            self.process.wait(10)
            self.reader.join(10)
            self.process.stdout.close()
            return self.process.returncode
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


class Monitor(Program):
    def __init__(self, *arguments, listen="127.0.0.1:0", peers="127.0.0.1:0"):
        live = [] if "--trace" in arguments or "--capture" in arguments else ["--peers-listen", peers]
        super().__init__(MONITOR, "--listen", listen, *live, *arguments)
        self.address = self.wait_for(r"(http://127\.0\.0\.1:\d+/)")[1]
        self.peers = self.wait_for(r"--monitor (\S+:\d+)")[1] if live else None


class Session:
    """Peers that tell a monitor; `own[i]` are arguments of the i-th alone."""

    def __init__(self, monitor, count, *arguments, own=None):
        own = own or [[]] * count
        common = ["--monitor", monitor.peers, "--control", "--duration", 600, *arguments]
        self.peers = [Program(PEER, "--listen", "127.0.0.1:0", "--wait-peers", count, *common, *own[0])]
        port = self.peers[0].wait_for(r"listening on .*:(\d+)$")[1]
        self.peers += [Program(PEER, "--join", f"127.0.0.1:{port}", *common, *own[i]) for i in range(1, count)]

    def end(self):
        for peer in self.peers:
            peer.stop(signal.SIGINT)
        return [peer.ended() for peer in self.peers]


class Browser:
    """Chromium; `script` runs JavaScript in the page, which has `padr` for the tests."""

    def __init__(self, width=1366, height=768, dark=False, phone=False):
        options = webdriver.ChromeOptions()
        # As root there is no sandbox; a container has little shared memory.
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                         "--hide-scrollbars", f"--window-size={width},{height}"):  # fmt: skip
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        options.binary_location = shutil.which("chromium") or shutil.which("chromium-browser") or ""
        driver = shutil.which("chromedriver")
        if not options.binary_location or not driver:
            skip("no Chromium, or no driver for it, here (packages chromium, chromium-driver)")
        try:
            self.driver = webdriver.Chrome(service=Service(driver), options=options)
        except WebDriverException as e:
            skip(f"Chromium does not start here: {e.msg}")
        self.driver.set_script_timeout(120)
        self.resize(width, height, phone)
        self.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": phone})
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})

    def resize(self, width, height, phone=False, scale=1):
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": phone},
        )

    def open(self, address):
        self.driver.get(address)
        wait(lambda: self.script("return window.padr !== undefined"), "the page's scripts")

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def from_now_on(self, expression):
        """A question whether `expression` has held since, if only for a moment: the page looks, ten times a second. On a busy
        machine the driver may ask once in seconds."""
        number = self.script(f"""
            const number = (window.held ??= []).push(false) - 1;
            const looking = setInterval(() => {{ if ({expression}) {{ held[number] = true; clearInterval(looking); }} }}, 100);
            return number;""")
        return lambda: self.script("return held[arguments[0]]", number)

    def module(self, text, *arguments):
        """Runs the body of an async function, which may import the page's modules, and returns what it returns."""
        done = self.driver.execute_async_script(
            "const done = arguments[arguments.length - 1], given = [...arguments].slice(0, -1);"
            f"(async (...given) => {{ {text} }})(...given).then((value) => done({{ value }}), (e) => done({{ error: `${{e}} ${{e.stack}}` }}));",
            *arguments,
        )
        if "error" in done:
            raise AssertionError(done["error"])
        return done.get("value")

    def find(self, selector):
        return self.driver.find_element("css selector", selector)

    def text(self, selector):
        return self.script("return document.querySelector(arguments[0]).textContent", selector)

    def picture(self, name, whole=False):
        """Keeps a screenshot, for people to look at."""
        os.makedirs(PICTURES, exist_ok=True)
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": whole})
        with open(os.path.join(PICTURES, f"{name}.png"), "wb") as f:
            f.write(base64.b64decode(shot["data"]))

    def complaints(self):
        """What the console has said since last asked."""
        return [e["message"] for e in self.driver.get_log("browser") if e["level"] in ("SEVERE", "WARNING")]

    def close(self):
        self.driver.quit()


def skip(why):
    print(f"SKIPPED: {why}", flush=True)
    for program in Program.started:
        program.end(signal.SIGKILL)
    os._exit(SKIPPED)


class Case(unittest.TestCase):
    """What setUpClass starts is shared by its tests, and ended after them, newest first."""

    @classmethod
    def start(cls, thing):
        cls.addClassCleanup(thing.close if isinstance(thing, Browser) else thing.end)
        return thing

    def check_console(self, browser):
        self.assertEqual(browser.complaints(), [])

    def wait_for_peers(self, browser, count):
        """Until the page has their views, and has said that they play."""
        waiting = "s.waits() || document.querySelector('#state').textContent.startsWith('waiting for more')"
        seen = f"const s = padr.session; return s.scene && !({waiting}) ? s.present().filter((p) => s.samples.sample(p.slot, 0)).length : 0"
        wait(lambda: browser.script(seen) == count, f"the views of {count} peers")


def main():
    print(f"programs: {MONITOR} {PEER}; screenshots: {PICTURES}", flush=True)
    unittest.main(verbosity=2)


__all__ = ["Browser", "Case", "MONITOR", "Monitor", "Program", "Session", "PATIENCE", "main", "os", "signal", "tempfile", "time", "wait"]
