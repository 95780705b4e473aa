"""Updates a second of the live page (closure, scene, numbers, sections), seen in Chromium."""

from __future__ import annotations

import shutil
import sys

import pmjac_pin as pj

ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

# A script in the page moves the first slider as soon as the last move was answered.
RATE = """(seconds) => new Promise((resolve) => {
  const slider = document.getElementById("motor-0");
  const middle = Number(slider.value);
  const start = performance.now(), before = pmjac.updates;
  let k = 0;
  const next = () => {
    const elapsed = (performance.now() - start) / 1000;
    if (elapsed > seconds) {
      document.removeEventListener("pmjac-update", next);
      resolve((pmjac.updates - before) / elapsed);
      return;
    }
    k += 1;
    slider.value = middle + 0.2 * Math.sin(k / 30);
    slider.dispatchEvent(new Event("input"));
  };
  document.addEventListener("pmjac-update", next);
  next();
})"""


def main() -> int:
    chromium = shutil.which("chromium")
    if chromium is None:
        print("The live page: not measured, there is no Chromium.")
        return 0
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for name in ("four_bar", "three_rps"):
            with pj.view(pj.load(name).home, open_browser=False, port=0) as viewer:
                # Scripts that wait evaluate text, which the page itself forbids.
                page = browser.new_page(bypass_csp=True)
                page.goto(viewer.url)
                page.wait_for_function("window.pmjac && pmjac.ready")
                page.evaluate(RATE, 1.0)
                print(f"live page of {name}: {page.evaluate(RATE, 4.0):.0f} updates a second")
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
