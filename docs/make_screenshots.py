"""Take the screenshots of the documentation: the live page in Chromium, without a window."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import pmjac_pin as pj

FOLDER = Path(__file__).parent
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = {"width": 1280, "height": 800}
LOADED, SLICED = "viewer_load", "viewer_slice"
DRAWN = "document.getElementById('slice').dataset.status === 'drawn'"


def poses() -> dict[str, pj.Configuration]:
    """Return what is to be seen, by the names of the files."""
    three_rps = pj.load("three_rps")
    return {
        "viewer_four_bar": pj.load("four_bar").close([1.9]),
        "viewer_three_rps": three_rps.close([1.1, 1.0, 0.9]),
        LOADED: pj.load("stewart_gough").close([0.7, 0.7, 0.62, 0.62, 0.66, 0.66]),
        SLICED: pj.load("planar_3rpr").close([0.42, 0.3, 0.34]),
        # A thousandth of a metre before the end of this assembly mode.
        "viewer_near_singular": three_rps.close([1.0, 1.972, 1.0]),
    }


def load_the_tool(page: Any) -> None:
    """Hang 20 kg at the tool, and show what motors hold within their effort limits."""
    page.uncheck("#linear")
    page.check("#force_polytope")
    page.fill("#weight-0-value", "20")
    page.press("#weight-0-value", "Enter")
    page.evaluate("document.getElementById('load-note').scrollIntoView({block: 'end'})")


def draw_the_slice(page: Any) -> None:
    """Draw the map of the first two motors."""
    page.click("#slice-title")
    page.click("#draw-slice")
    wait(page, DRAWN)
    page.locator("#slice").scroll_into_view_if_needed()


def wait(page: Any, condition: str) -> None:
    """Wait, though the page's policy forbids `eval` and Playwright's own waiting with it."""
    while not page.evaluate(condition):
        page.wait_for_timeout(50)


def take(browser: Any, configuration: pj.Configuration, path: Path) -> None:
    """Write what the page shows of a configuration when everything has arrived."""
    with pj.view(configuration, open_browser=False, port=0) as viewer:
        page = browser.new_page(viewport=SIZE)
        page.goto(viewer.url)
        wait(page, "Boolean(window.pmjac?.ready)")
        if path.stem == LOADED:
            load_the_tool(page)
        if path.stem == SLICED:
            draw_the_slice(page)
        page.wait_for_timeout(1500)
        page.screenshot(path=path)
        page.close()
    print(f"{path} ({path.stat().st_size // 1000} kB)")


def main() -> int:
    """Take all of them."""
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415
    except ImportError:
        print("screenshots need Playwright: pip install playwright", file=sys.stderr)
        return 2
    chromium = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if chromium is None:
        print("screenshots need a browser: install Chromium", file=sys.stderr)
        return 2
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for name, configuration in poses().items():
            take(browser, configuration, FOLDER / f"{name}.png")
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
