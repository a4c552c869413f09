"""The page of `crosscut report` in a real browser: nothing is asked of the network, nothing fails, and it fits a phone."""

import shutil

from browser import CHROMIUM, Browser
from flights import Flights
from verdicts import Verdicts

SIZES = {"desktop": "1200x900", "phone": "400x850"}
WHAT = "the page of a flight in a browser"


def check(flights: Flights, verdicts: Verdicts):
    binary = next((found for name in CHROMIUM if (found := shutil.which(name))), None)
    if binary is None:
        return verdicts.failed(WHAT, "there is no Chromium: apt-get install chromium")
    for flight in [flights.shipped()[0], *flights.real()[:1]]:
        page = flights.work / f"{flight.name}.html"
        flights.crosscut("report", flight.path, "--out", page, "--quiet").expect(0)
        for name, size in SIZES.items():
            with Browser(binary, page.as_uri(), size) as browser:
                browser.wait(2)
                picture = flights.work.parent / f"page-{flight.name}-{name}.png"
                browser.save(picture)
                drawn = browser.value("[...document.querySelectorAll('svg')].filter(svg => svg.getBoundingClientRect().width > 50).length")
                overflow = browser.value("document.documentElement.scrollWidth - document.documentElement.clientWidth")
                foreign = [url for url in browser.asked_for if url != page.as_uri() and not url.startswith("data:")]
                fits = drawn >= 3 and overflow <= 0 and not foreign and not browser.said
                figures = f"{drawn} drawings, {overflow} px beyond the window, {foreign}, {browser.said}; {picture.name}"
                verdicts.that(fits, f"{WHAT}, {flight.name}, {name}", figures)
