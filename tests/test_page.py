"""The page in a real browser: Chromium, driven by Playwright."""

from __future__ import annotations

import json
import os
import re
import shutil
import time

import numpy as np
import pytest
from bench_page import RATE
from mechanisms import loaded

import pmjac_pin as pj

pytestmark = pytest.mark.slow

ARGUMENTS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
DESKTOP, TELEPHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}


def _missing(reason):
    if os.environ.get("CI"):
        pytest.fail(f"{reason}; it is required where CI is set")
    pytest.skip(reason)


@pytest.fixture(scope="module")
def browser():
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _missing("Playwright is not installed")
    names = ("chromium", "chromium-browser", "google-chrome")
    chromium = next(filter(None, map(shutil.which, names)), None)
    if chromium is None:
        _missing("no Chromium found")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        yield browser
        browser.close()


# meshcat follows the size of its frame with the next event.
LAID_OUT = """(() => {
  const scene = document.getElementById("scene");
  return scene.contentWindow.viewer.renderer.domElement.clientHeight === scene.clientHeight;
})()"""


@pytest.fixture
def open_page(browser):
    """Open pages; at the end none of them may have complained."""
    pages, complaints = [], []

    def listen(message):
        # The page tries again when the server has gone: the browser writes that down.
        if message.type == "error" and not message.text.startswith("WebSocket connection to"):
            complaints.append(message.text)

    def opened(viewer, size=DESKTOP):
        page = browser.new_page(viewport=size, accept_downloads=True)
        pages.append(page)
        page.on("console", listen)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("response", lambda r: r.status >= 400 and complaints.append(f"{r.status} {r.url}"))
        page.goto(viewer.url)
        wait(page, "window.pmjac && pmjac.ready")
        wait(page, "document.getElementById('scene').contentWindow.viewer")
        wait(page, LAID_OUT)
        return page

    yield opened
    for page in pages:
        page.close()
    assert complaints == []


@pytest.fixture
def mechanism():
    return loaded("three_rps")


def numbers(text):
    """Read numbers off the page, with the digits that each of them shows."""
    found = re.findall(r"−?\d+\.?\d*(?:e[+−]?\d+)?", text)
    return [(float(n.replace("−", "-")), len(n.partition(".")[2].split("e")[0])) for n in found]


FRAME = "document.getElementById('scene').contentWindow"


def agree(text, values):
    shown = numbers(text)
    assert len(shown) == len(values), (text, values)
    for (number, digits), value in zip(shown, values, strict=True):
        assert abs(number - value) <= 0.5001 * 10.0**-digits, (text, values)


def wait(page, condition, seconds=20):
    """Wait for a condition: Playwright's own waiting needs `eval`, which the page forbids."""
    end = time.monotonic() + seconds
    while not page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, f"in vain: {condition}"
        page.wait_for_timeout(20)


def quiet(page):
    wait(page, "pmjac.idle()")


def thumb(page, index, value):
    """Return where the thumb of a slider is, for a value."""
    box = page.locator(f"#motor-{index}").bounding_box()
    low, high = (float(page.locator(f"#motor-{index}").get_attribute(a)) for a in ("min", "max"))
    share = (value - low) / (high - low)
    return box["x"] + 8 + share * (box["width"] - 16), box["y"] + box["height"] / 2


def drag(page, index, start, end, steps=12):
    page.mouse.move(*thumb(page, index, start))
    page.mouse.down()
    page.mouse.move(*thumb(page, index, end), steps=steps)
    page.mouse.up()
    page.wait_for_timeout(100)
    quiet(page)


def picture(page):
    """Return the pixels of the scene as a PNG's data, drawn now."""
    return page.evaluate("document.getElementById('scene').contentWindow.viewer.capture_image()")


def outlines(page):
    polygons = page.locator("#sections polygon")
    return [polygons.nth(k).get_attribute("points") for k in range(3)]


def check_numbers(page, configuration):
    """Everything the page shows against Python, to the digits shown."""
    jacobian = configuration.jacobian()
    agree(page.inner_text("#sigma-v"), np.linalg.svd(jacobian.Jv_eq, compute_uv=False))
    agree(page.inner_text("#sigma-w"), np.linalg.svd(jacobian.Jw_eq, compute_uv=False))
    singularity = configuration.singularity()
    agree(page.inner_text("#smallest"), [singularity.smallest])
    agree(page.inner_text("#condition"), [singularity.condition])
    for k in range(6):
        row = page.locator("#jacobian tbody tr").nth(k).locator("td").all_inner_texts()
        agree(" ".join(row), jacobian.J_eq[k])
    ellipsoid = jacobian.velocity_ellipsoid()
    for plane in ("zy", "zx", "xy"):
        agree(page.inner_text(f"#radii-{plane}"), ellipsoid.section(plane).radii)
    for k, value in enumerate(configuration.actuated):
        assert float(page.input_value(f"#motor-{k}-value")) == pytest.approx(value, abs=5.1e-5)


def test_a_slider_is_dragged_with_the_mouse(viewer, open_page):
    page = open_page(viewer)
    check_numbers(page, viewer.configuration)
    before = picture(page), outlines(page)
    drag(page, 0, 1.0, 1.3)
    configuration = viewer.configuration
    assert configuration.actuated[0] == pytest.approx(1.3, abs=0.03)
    np.testing.assert_allclose(configuration.actuated[1:], 1.0)
    check_numbers(page, configuration)
    assert page.evaluate("pmjac.updates") > 1  # how many more is the machine's load
    assert picture(page) != before[0]
    assert all(new != old for new, old in zip(outlines(page), before[1], strict=True))
    assert page.input_value("#pose") == ""
    page.click("#home")
    quiet(page)
    check_numbers(page, viewer.configuration)
    assert page.input_value("#pose") == "home"


def test_the_sections_are_those_of_the_ellipsoid(viewer, open_page):
    page = open_page(viewer)
    viewer.update(viewer.configuration.mechanism.pose("lecture_b"))
    wait(page, "pmjac.state.pose === 'lecture_b'")
    check_numbers(page, viewer.configuration)
    ellipsoid = viewer.configuration.jacobian().velocity_ellipsoid()
    for plane, points in zip(("zy", "zx", "xy"), outlines(page), strict=True):
        drawn = np.array([pair.split(",") for pair in points.split()], dtype=float)
        limit = float(page.text_content(f"#section-{plane} .limit").replace("±", ""))
        drawn = (drawn - 60.0) * [limit / 50.0, -limit / 50.0]
        expected = ellipsoid.section(plane).points(73)[:-1]
        if not np.allclose(drawn, expected, atol=0.01 * limit):  # the other way round
            np.testing.assert_allclose(drawn, expected[:1].tolist() + expected[:0:-1].tolist(),
                                       atol=0.01 * limit)  # fmt: skip


def test_the_end_of_the_range(viewer, open_page):
    page = open_page(viewer)
    drag(page, 1, 1.0, 2.9, steps=30)
    end = viewer.configuration.actuated[1]
    assert 1.9 < end < 2.0
    assert "l2 stops at 1.97" in page.inner_text("#notice")
    assert float(page.input_value("#motor-1")) == pytest.approx(end)
    assert "come free" in page.inner_text("#warning")
    assert page.locator("#status").get_attribute("aria-live") == "polite"
    assert page.inner_text("#jacobian td >> nth=2") == "—"
    assert "no equivalent Jacobian" in page.inner_text("#refusal")
    drag(page, 1, end, 1.5)  # and back
    assert viewer.configuration.actuated[1] == pytest.approx(1.5, abs=0.03)
    assert page.inner_text("#warning") == ""
    check_numbers(page, viewer.configuration)


def test_near_a_singularity_the_page_and_the_scene_warn(viewer, open_page):
    page = open_page(viewer)
    before = picture(page)
    page.fill("#motor-1-value", "1.9729")
    page.press("#motor-1-value", "Enter")
    page.wait_for_selector(".status.near")
    assert "theta1" in page.inner_text("#warning")
    check_numbers(page, viewer.configuration)
    assert picture(page) != before
    items = viewer._hub.session.scene().items
    assert any("free" in item.name and item.visible for item in items)


def test_a_value_that_is_none(viewer, open_page):
    page = open_page(viewer)
    for text in ("abc", "99", "1e999", "NaN", "", "1,1,1"):
        page.fill("#motor-0-value", text)
        page.press("#motor-0-value", "Enter")
        page.wait_for_selector(".status.error")
        assert page.inner_text("#notice"), text
        np.testing.assert_array_equal(viewer.configuration.actuated, [1.0, 1.0, 1.0])
        page.press("#motor-0-value", "Escape")
        assert page.input_value("#motor-0-value") == "1.0000"
        page.click("#home")
        wait(page, "!document.querySelector('.status.error')")


def test_an_exact_value(viewer, open_page):
    page = open_page(viewer)
    page.fill("#motor-0-value", "1,234")
    page.press("#motor-0-value", "Tab")
    wait(page, "pmjac.updates > 0")
    assert viewer.configuration.actuated[0] == pytest.approx(1.234, abs=1e-12)


def test_two_tabs_see_the_same(viewer, open_page):
    one, two = open_page(viewer), open_page(viewer)
    drag(one, 0, 1.0, 1.2)
    wait(two, "Math.abs(pmjac.state.values[0] - 1.2) < 0.05")
    check_numbers(two, viewer.configuration)
    assert one.inner_text("#jacobian") == two.inner_text("#jacobian")
    two.select_option("#pose", "lecture_a")
    wait(one, "pmjac.state.pose === 'lecture_a'")
    assert one.input_value("#pose") == "lecture_a"


def test_reload_keeps_the_pose(viewer, open_page):
    page = open_page(viewer)
    drag(page, 2, 1.0, 1.2)
    page.check("#angular")
    quiet(page)
    before = viewer.configuration
    page.reload()
    wait(page, "window.pmjac && pmjac.ready")
    assert viewer.configuration is before
    check_numbers(page, before)
    assert page.is_checked("#angular")


def test_ellipsoids_are_chosen_and_scaled(viewer, open_page):
    page = open_page(viewer)
    viewer.update(viewer.configuration.mechanism.pose("lecture_b"))
    seen = {picture(page)}
    for name in ("angular", "force", "linear"):
        page.locator(f"#{name}").click()
        page.wait_for_timeout(300)
        seen.add(picture(page))
    page.focus("#scale")
    page.keyboard.press("End")
    page.wait_for_timeout(300)
    seen.add(picture(page))
    assert len(seen) == 5
    assert viewer._hub.session.options.scale == pytest.approx(10.0)
    assert page.inner_text("#scale-value").endswith("10.00")


def test_snapshot_and_reset_view(viewer, open_page, tmp_path):
    page = open_page(viewer)
    first = picture(page)
    box = page.locator("#scene").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 320, box["y"] + 260, steps=4)
    page.mouse.up()
    assert picture(page) != first
    page.click("#reset")
    with page.expect_download() as download:
        page.click("#snapshot")
    name = download.value.suggested_filename
    assert re.fullmatch(r"three_rps_\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d\.png", name)
    download.value.save_as(tmp_path / "x.png")
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")
    assert picture(page) == first


def test_reset_view_frames_what_is_shown_now(open_page):
    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        before = picture(page)
        page.fill("#motor-0-value", "3.1")
        page.press("#motor-0-value", "Enter")
        quiet(page)
        page.click("#reset")
        quiet(page)
        edge = pixels(page)
        ground = np.abs(edge - edge[:, :1]).max(axis=2) > 25
        assert not ground[:, [0, -1]].any()
        page.click("#home")
        page.click("#reset")
        quiet(page)
        assert picture(page) == before


VISIBLE = """() => {
  const inner = document.getElementById("scene").contentWindow;
  const image = new inner.Image();
  image.src = inner.viewer.capture_image();
  return image.decode().then(() => {
    const canvas = inner.document.createElement("canvas");
    [canvas.width, canvas.height] = [64, 48];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0, 64, 48);
    return Array.from(context.getImageData(0, 0, 64, 48).data);
  });
}"""


def pixels(page):
    return np.array(page.evaluate(VISIBLE), dtype=float).reshape(48, 64, 4)[:, :, :3]


LABELS = """() => {
  const inner = document.getElementById("scene").contentWindow;
  inner.viewer.render();
  const found = [];
  inner.viewer.scene.traverseVisible((object) => {
    if (object.isSprite) found.push([object.userData.text, ...object.userData.rectangle]);
  });
  return [inner.innerWidth, inner.innerHeight, found];
}"""


@pytest.fixture(scope="module")
def pictures():
    """What was seen of each machine on each screen."""
    return {"desktop": [], "telephone": []}


@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_every_mechanism_is_framed_and_labelled(open_page, pictures, name):
    """On both screens: to open a page takes seconds, to give it another size does not."""
    with pj.view(loaded(name).home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        for screen, others in pictures.items():
            if screen == "telephone":
                page.set_viewport_size(TELEPHONE)
                wait(page, LAID_OUT)
                page.click("#reset")
                quiet(page)
            wait(page, f"({LABELS})()[2].length > 0")
            page.wait_for_timeout(300)
            seen = pixels(page)
            check_framed(seen)
            assert all(np.abs(seen - other).mean() > 0.5 for other in others)
            others.append(seen)
            check_labels(page, viewer.configuration)
        page.close()


def check_framed(seen):
    """What is shown fills much of the picture, and nothing is cut."""
    drawn = np.abs(seen - seen[:, :1]).max(axis=2) > 25  # the left edge shows the ground
    assert drawn.sum() > 20  # not blank
    rows, columns = np.nonzero(drawn)
    assert max(np.ptp(rows) / 48, np.ptp(columns) / 64) > 0.5
    edge = np.concatenate([drawn[0], drawn[-1], drawn[:, 0], drawn[:, -1]])
    assert edge.sum() <= 2


def check_labels(page, configuration):
    """None lies on another or outside, and those of the motors can be put away."""
    width, height, labels = page.evaluate(f"({LABELS})()")
    texts = [text for text, *_ in labels]
    assert set(texts) >= set(configuration.mechanism.actuated)
    for k, (text, left, top, across, down) in enumerate(labels):
        assert left >= 0 and top >= 0, text  # noqa: PT018
        assert left + across <= width, text
        assert top + down <= height, text
        for other, x, y, w, h in labels[k + 1 :]:
            apart = left + across <= x or x + w <= left or top + down <= y or y + h <= top
            assert apart, (text, other)
    page.uncheck("#names")
    quiet(page)
    wait(page, f"({LABELS})()[2].length === {len(texts) - len(configuration.actuated)}")
    page.check("#names")
    quiet(page)
    wait(page, f"({LABELS})()[2].length === {len(texts)}")


def test_updates_keep_up_with_a_slider_that_never_rests(viewer, open_page):
    """As fast as they are answered; how fast that is, `make bench` measures."""
    page = open_page(viewer)
    assert page.evaluate(RATE, 2.0) > 0.0
    quiet(page)
    check_numbers(page, viewer.configuration)


def test_keyboard_alone(viewer, open_page):
    page = open_page(viewer)
    visited = []
    for _ in range(26):
        page.keyboard.press("Tab")
        visited.append(page.evaluate("document.activeElement.id"))
        if visited[-1] == "scale":
            break
        if visited[-1] == "scene":
            shown = f"{FRAME}.getComputedStyle({FRAME}.document.activeElement, '::after')"
            style = page.evaluate(f"{shown}.borderTopStyle")
        else:
            style = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert style == "solid", visited[-1]
    motors = [f"motor-{k}{end}" for k in range(3) for end in ("-play", "", "-value")]
    buttons = ["scene", "home", "reset", "snapshot", "pose", "degrees", "names"]
    assert visited == [
        *buttons,
        *motors,
        "slice-title",
        "design-title",
        "passive-title",
        "find-modes",
        "linear",
        "angular",
        "force",
        "velocity_polytope",
        "force_polytope",
        "scale",
    ]
    page.focus("#motor-0")
    page.keyboard.press("ArrowRight")
    quiet(page)
    assert 1.0 < viewer.configuration.actuated[0] < 1.1
    for key in ("ArrowLeft", "PageUp", "PageDown"):
        page.keyboard.press(key)
        quiet(page)
    assert viewer.configuration.actuated[0] == pytest.approx(1.0)
    page.focus("#angular")
    page.keyboard.press("Space")
    wait(page, "pmjac.state.drawn.angular")


def test_angles_in_degrees(open_page):
    ankle = loaded("ankle")
    with pj.view(ankle.home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        page.check("#degrees")
        page.fill("#motor-0-value", "20")
        page.press("#motor-0-value", "Enter")
        quiet(page)
        there = viewer.configuration
        assert there.actuated[0] == pytest.approx(np.deg2rad(20.0), abs=1e-12)
        assert page.input_value("#motor-0-value") == "20.00"
        page.click("#passive-title")
        shown = page.locator("#passive tr").first.inner_text().split()
        value = f"{np.rad2deg(there.passive[0]):.2f}".replace("-", "\u2212")
        assert shown == [there.mechanism.passive[0], value, "°"]
        page.uncheck("#degrees")
        assert page.input_value("#motor-0-value") == "0.3491"
        page.close()


@pytest.mark.parametrize("frame", ["LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"])
def test_the_jacobian_in_its_frames_and_as_text(viewer, open_page, frame):
    page = open_page(viewer)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.select_option("#frame", frame)
    page.click("#copy")
    wait(page, "document.getElementById('copy').textContent === 'Copied'")
    text = page.evaluate("navigator.clipboard.readText()")
    assert re.fullmatch(r"np\.array\(\[.*\]\)", text)
    expected = viewer.configuration.jacobian(frame).J_eq
    np.testing.assert_allclose(json.loads(text[len("np.array(") : -1]), expected, atol=1e-12)
    cells = page.locator("#jacobian td").all_inner_texts()
    numbers = [float(cell.replace("\u2212", "-")) for cell in cells if cell.strip()]
    np.testing.assert_allclose(numbers, expected.ravel(), atol=1e-3)


def test_every_control_has_a_name(viewer, open_page):
    page = open_page(viewer)
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, iframe, svg")].filter(
          (e) => !(e.labels?.length || e.getAttribute("aria-label") || e.title
                   || e.textContent.trim())
        ).map((e) => e.id)"""
    )
    assert unnamed == []
    assert page.get_attribute("#motor-0", "aria-valuetext") == "1.0000 m"
    assert page.locator("html").get_attribute("lang") == "en"


OVERLAPS = """() => {
  const boxes = [...document.querySelectorAll(
    "button, input, select, output, h1, h2, .readout th, .readout td, figure, .limits"
  )].filter((e) => e.offsetParent !== null).map((e) => [e, e.getBoundingClientRect()]);
  const found = [];
  for (const [a, p] of boxes) for (const [b, q] of boxes) {
    if (a === b || a.contains(b) || b.contains(a)) continue;
    const width = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const height = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    if (width > 1 && height > 4) found.push([a.id || a.textContent, b.id || b.textContent]);
  }
  return found;
}"""


@pytest.mark.parametrize("size", [DESKTOP, TELEPHONE], ids=["desktop", "telephone"])
@pytest.mark.parametrize("name", ["three_rps", "four_bar", "ur5"])
def test_nothing_overlaps_and_nothing_is_too_wide(open_page, name, size):
    with pj.view(loaded(name).home, open_browser=False, port=0) as viewer:
        page = open_page(viewer, size)
        assert page.evaluate("document.documentElement.scrollWidth") == size["width"]
        assert page.evaluate(OVERLAPS) == []
        smallest = page.evaluate(
            """Math.min(...[...document.querySelectorAll("p, th, td, label, button, span, h2")]
              .filter((e) => e.offsetParent && e.textContent.trim())
              .map((e) => parseFloat(getComputedStyle(e).fontSize)))"""
        )
        assert smallest >= 11
        panel = page.evaluate("document.querySelector('.panel').scrollWidth")
        assert panel <= page.evaluate("document.querySelector('.panel').clientWidth")
        page.close()


def test_numbers_do_not_jump(viewer, open_page):
    page = open_page(viewer)
    places = """() => [...document.querySelectorAll("section, .bar, #jacobian td, .numbers")]
      .map((e) => { const r = e.getBoundingClientRect(); return [r.left, r.top, r.right]; })"""
    before = page.evaluate(places)
    for value in ("1.3", "0.8", "1.9", "1.2"):
        page.fill("#motor-1-value", value)
        page.press("#motor-1-value", "Enter")
        quiet(page)
        assert page.evaluate(places) == before


def test_when_python_ends_the_page_says_so_and_goes_on_when_it_is_back(open_page):
    viewer = pj.view(loaded("four_bar").home, open_browser=False, port=0)
    page = open_page(viewer)
    page.focus("#motor-0")
    viewer.close()
    page.wait_for_selector(".status.error")
    assert "connection to Python has ended" in page.inner_text("#notice")
    assert page.is_disabled("#motor-0")
    wait(page, "pmjac.idle()")
    there = loaded("three_rps").close([1.1, 1.0, 0.9])
    with pj.view(there, open_browser=False, port=viewer.port) as again:
        assert again.url == viewer.url
        wait(page, "pmjac.state.about?.mechanism === 'three_rps'")
        assert page.evaluate("document.activeElement.id") == "motor-0"
        check_numbers(page, there)
        page.keyboard.press("ArrowRight")
        wait(page, "pmjac.updates > 0")
        assert again.configuration.actuated[0] > 1.1
        # The picture is the new one, and nothing of the old one is left.
        tree = f"{FRAME}.viewer.scene_tree.children.pmjac"
        links = f"Object.keys({tree}?.children._links?.children ?? {{}})"
        wait(page, f"{links}.includes('_plate')")
        assert "_crank" not in page.evaluate(links)


def test_the_picture_is_turned_with_keys(viewer, open_page):
    page = open_page(viewer)
    seen = [picture(page)]
    page.keyboard.press("Tab")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
        seen.append(picture(page))
    assert len(set(seen)) == 4
    for key in ("ArrowRight", "ArrowDown", "-"):
        page.keyboard.press(key)
    camera = page.evaluate(f"{FRAME}.viewer.camera.position.toArray()")
    page.click("#reset")
    quiet(page)
    np.testing.assert_allclose(page.evaluate(f"{FRAME}.viewer.camera.position.toArray()"), camera)
    assert picture(page) == seen[0]


def test_a_slider_that_is_held_beyond_the_end_stays_there(viewer, open_page):
    page = open_page(viewer)
    drag(page, 1, 1.0, 1.9)
    page.evaluate("""() => {
      window.said = new Set();
      window.places = [];
      const look = () => {
        const { state } = window.pmjac;
        if (state.notice.kind === "stop") {
          said.add(document.getElementById("notice").textContent);
          places.push(document.getElementById("motor-1").valueAsNumber - state.values[1]);
        }
        requestAnimationFrame(look);
      };
      look();
    }""")
    page.mouse.move(*thumb(page, 1, 1.9))
    page.mouse.down()
    for value in (2.2, 2.9, 2.4, 2.7, 2.1, 2.8):
        page.mouse.move(*thumb(page, 1, value), steps=5)
        page.wait_for_timeout(100)
    wait(page, "places.length > 5")
    assert page.evaluate("said.size") == 1
    assert page.evaluate("Math.max(...places.slice(1).map(Math.abs))") < 1e-9
    page.mouse.move(*thumb(page, 1, 1.5), steps=5)
    page.mouse.up()
    quiet(page)
    assert viewer.configuration.actuated[1] == pytest.approx(1.5, abs=0.03)


def test_the_legend_names_what_is_there(open_page):
    texts = {}
    for name in ("serial_2r", "three_rps", "three_rps_ss"):
        with pj.view(loaded(name).home, open_browser=False, port=0) as viewer:
            page = open_page(viewer)
            texts[name] = page.locator("#legend li").all_inner_texts()
            page.close()
    assert texts["serial_2r"] == ["motor", "tool x, y, z", "load"]
    assert set(texts["three_rps_ss"]) - set(texts["three_rps"]) == {"its rod"}


def test_without_webgl_the_picture_is_words_and_all_else_works(browser, viewer):
    page = browser.new_page()
    complaints = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(viewer.url)
    wait(page, "window.pmjac && pmjac.ready")
    words = f"{FRAME}.document.body.innerText"
    wait(page, f"{words}.includes('no WebGL')")
    page.fill("#motor-0-value", "1.2")
    page.press("#motor-0-value", "Enter")
    wait(page, "pmjac.updates > 0")
    check_numbers(page, viewer.configuration)
    assert "no WebGL" in page.evaluate(words)
    assert complaints == []
    page.close()


def test_a_saved_page_needs_no_server(browser, tmp_path):
    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        viewer.save_html(tmp_path / "x.html")
        (tmp_path / "notebook.html").write_text(viewer._repr_html_(), encoding="utf-8")
    complaints = []
    for name in ("x.html", "notebook.html"):
        page = browser.new_page(viewport=DESKTOP)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda m: m.type == "error" and complaints.append(m.text))
        page.goto((tmp_path / name).as_uri())
        page.wait_for_timeout(1500)
        blank = browser.new_page(viewport=DESKTOP)
        assert page.screenshot() != blank.screenshot()
        if name == "x.html":
            assert page.evaluate("stage.viewer.scene_tree.children.pmjac !== undefined")
        blank.close()
        page.close()
    assert complaints == []
