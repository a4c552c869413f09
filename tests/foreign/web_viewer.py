"""The web viewer that a program built with the feature `web` serves: a real browser opens its page and draws the walls."""

import shutil
import time
from pathlib import Path

import numpy as np
from PIL import Image

from browser import CHROMIUM, Browser
from flights import Flights
from verdicts import Verdicts
from viewing import SIZE, Served

# Two of the colours of walls.
WALLS_RGB = ((0x56, 0xB4, 0xE9), (0xE6, 0x9F, 0x00))
# Pixels of a colour that are a wall.
WALL_PIXELS = 200
DEADLINE_S = 240
WHAT = "web viewer in a browser"


def check(flights: Flights, verdicts: Verdicts):
    binary = next((found for name in CHROMIUM if (found := shutil.which(name))), None)
    if binary is None:
        return verdicts.failed(WHAT, "there is no Chromium: apt-get install chromium")
    with Served(flights.crosscut.command("run", flights.shipped()[0].path, "--serve=127.0.0.1:0")) as served:
        served.wait_for("still served")
        if served.page is None:
            return verdicts.failed(WHAT, "it is not built in: cargo build --release -p crosscut --features web")
        picture, start = flights.work.parent / "browser.png", time.monotonic()
        found = 0
        with Browser(binary, f"{served.page}&renderer=webgl", SIZE) as browser:
            while found < len(WALLS_RGB) and time.monotonic() - start < DEADLINE_S:
                browser.wait(3)
                browser.save(picture)
                found = walls_drawn(picture)
            panics = [text for text in browser.said if "panic" in text.lower()]
        figures = f"{found} of {len(WALLS_RGB)} colours of walls after {time.monotonic() - start:.0f} s; {picture.name}"
        verdicts.that(found == len(WALLS_RGB) and not panics, WHAT, figures + "".join(panics)[:200])


def walls_drawn(picture: Path) -> int:
    """How many of the walls' colours fill some pixels."""
    pixels = np.array(Image.open(picture).convert("RGB")).astype(int)
    return sum(int(np.sum(np.abs(pixels - colour).max(axis=2) < 12) >= WALL_PIXELS) for colour in WALLS_RGB)
