#!/usr/bin/env python3
"""Takes docs/monitor.png, the picture of the page in the README: PADR_MONITOR PADR_PEER FOLDER. See browser.py."""

import browser
from browser import *


def take():
    monitor = Monitor()
    session = Session(monitor, 4, "--netem", "delay 100ms 50ms loss 10%", own=[["--input", f"wander:{i}"] for i in range(4)])
    page = Browser(1280, 757)
    try:
        page.open(monitor.address)
        wait(lambda: page.script("return padr.session.scene && padr.session.present().length") == 4, "4 peers")
        wait(lambda: "identical" in page.text("#verdict"), "the hashes")
        time.sleep(8)
        page.picture("monitor")
    finally:
        page.close()
        session.end()
        monitor.end()


if __name__ == "__main__":
    take()
    print(f"{browser.PICTURES}/monitor.png")
