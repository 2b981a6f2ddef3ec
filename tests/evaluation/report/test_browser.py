"""The report in a real browser: it opens offline, pictures decode, the gallery lives."""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

CHROMIUM = Path("/usr/bin/chromium")


# Of this module alone: while a browser lives so does its event loop, and Snakemake plans in none.
@pytest.fixture(scope="module")
def browser():
    if not CHROMIUM.exists():
        pytest.skip(f"no browser at {CHROMIUM} (make test-machine)")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as session:
        arguments = ["--disable-gpu", "--disable-quic"]
        chromium = session.chromium.launch(executable_path=str(CHROMIUM), args=arguments)
        yield chromium
        chromium.close()


@pytest.fixture(params=[1280, 360])
def page(browser, planted_page, request):
    viewport = {"width": request.param, "height": 800}
    with browser.new_context(viewport=viewport, offline=True) as context:
        opened = context.new_page()
        opened.goto(planted_page.as_uri(), wait_until="load")
        yield opened


def test_the_page_opens_without_errors_or_requests(page):
    messages, requests = [], []
    page.on("console", lambda message: messages.append(message.text))
    page.on("pageerror", lambda error: messages.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.reload(wait_until="load")
    page.wait_for_timeout(200)
    assert messages == []
    assert [url for url in requests if not url.startswith("data:")] == [page.url]


def test_every_image_of_every_scene_decodes_and_has_alt_text(page):
    assert page.locator("#scene option").count() == 4
    for scene in range(4):
        page.select_option("#scene", str(scene))
        page.evaluate("Promise.all([...document.images].map(image => image.decode()))")
        bad = "[...document.images].filter(i => !(i.naturalWidth > 0) || !i.alt.trim()).length"
        assert page.evaluate(bad) == 0


def test_the_depth_cursor_follows_the_pointer(page):
    stage = page.locator("#panels .stage.observed")
    stage.scroll_into_view_if_needed()
    box = stage.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    n_rows = int(page.locator("#readout").get_attribute("aria-valuemax")) + 1
    readout = page.locator("#readout").inner_text()
    row, line = map(int, re.match(r"range bin (\d+), range line (\d+)", readout).groups())
    # A pixel of the screen is a few of the scene.
    assert abs(row - n_rows / 2) < 5
    assert abs(line - 64) < 5
    delay_ns = float(re.search(r"([\d.-]+) ns two-way from the surface", readout)[1])
    depth_m = float(re.search(r"([\d.]+) m deep in snow", readout)[1])
    # Snow of 340 kg m-3; rounded to 0.1 ns and 1 cm.
    assert abs(depth_m - 0.299792458 * delay_ns / (2 * 1.2873)) < 0.02
