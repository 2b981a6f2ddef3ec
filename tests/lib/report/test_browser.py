"""The report in a real browser: it opens, pictures decode, the gallery lives, it fits a phone and a sheet of paper."""

import csv
import io
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

CHROMIUM = Path("/usr/bin/chromium")
OFF = ("gpu", "quic", "background-networking", "component-update", "sync")
OPTIONS = ["--no-sandbox", "--no-first-run", *(f"--disable-{name}" for name in OFF)]


@pytest.fixture(scope="session")
def browser():
    if not CHROMIUM.exists():
        pytest.skip(f"no browser at {CHROMIUM}")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as session:
        chromium = session.chromium.launch(executable_path=str(CHROMIUM), args=OPTIONS)
        yield chromium
        chromium.close()


class Opened:
    """A page in the browser, with what it said and asked for."""

    def __init__(self, browser, path, width, **options):
        self.context = browser.new_context(viewport={"width": width, "height": 800}, **options)
        self.page = self.context.new_page()
        self.messages, self.requests = [], []
        self.page.on("console", lambda message: self.messages.append(message.text))
        self.page.on("pageerror", lambda error: self.messages.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri(), wait_until="load")


@pytest.fixture(params=[1280, 360], ids=["desktop", "phone"])
def opened(browser, planted_page, request):
    opened = Opened(browser, planted_page, request.param)
    yield opened
    opened.context.close()


def test_the_page_opens_without_errors_or_requests(opened, planted_page):
    opened.page.wait_for_timeout(200)
    assert opened.messages == []
    assert [url for url in opened.requests if not url.startswith("data:")] == [planted_page.as_uri()]


def test_every_image_of_every_scene_decodes_and_has_alt_text(opened):
    page = opened.page
    n_scenes = page.locator("#scene option").count()
    assert n_scenes > 0
    for scene in range(n_scenes):
        page.select_option("#scene", str(scene))
        page.evaluate("Promise.all([...document.images].map(image => image.decode()))")
        bad = page.evaluate(
            "[...document.images].filter(i => !(i.naturalWidth > 0) || !i.alt.trim()).map(i => i.src.slice(0, 60))"
        )
        assert bad == []


def test_the_layer_switch_shows_and_hides_layers(opened):
    page = opened.page
    # The scene of most layers is last: it has some whatever the run.
    page.select_option("#scene", str(page.locator("#scene option").count() - 1))
    layers = page.locator("#panels .stage.phy .overlay")
    assert layers.locator("polyline").count() > 0
    assert layers.evaluate("node => getComputedStyle(node).visibility") == "visible"
    page.uncheck("#layers")
    assert layers.evaluate("node => getComputedStyle(node).visibility") == "hidden"
    page.focus("#layers")
    page.keyboard.press("Space")
    assert layers.evaluate("node => getComputedStyle(node).visibility") == "visible"


def place(page):
    """Range bin and range line that the readout names."""
    text = page.locator("#readout").inner_text()
    return tuple(int(number) for number in re.match(r"range bin (\d+), range line (\d+)", text).groups())


def test_the_depth_cursor_moves_by_keyboard(opened):
    page = opened.page
    row, line = place(page)
    page.focus("#readout")
    moves = [("ArrowDown", 1, 0), ("PageDown", 11, 0), ("ArrowUp", 10, 0), ("ArrowLeft", 10, -1), ("PageUp", 0, -1)]
    for key, rows, lines in moves:
        page.keyboard.press(key)
        assert place(page) == (row + rows, line + lines)
    page.keyboard.press("Home")
    assert place(page)[0] == 0
    page.keyboard.press("ArrowUp")
    assert place(page)[0] == 0
    page.keyboard.press("End")
    readout = page.locator("#readout")
    assert place(page)[0] == int(readout.get_attribute("aria-valuemax")) == int(readout.get_attribute("aria-valuenow"))
    for cursor in page.locator("#panels .cursor.across").all():
        assert float(cursor.get_attribute("y1")) == place(page)[0]


def test_the_depth_cursor_follows_the_pointer(opened):
    page = opened.page
    stage = page.locator("#panels .stage.observed")
    stage.scroll_into_view_if_needed()
    box = stage.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    n_rows = int(page.locator("#readout").get_attribute("aria-valuemax")) + 1
    row, line = place(page)
    # A pixel of the screen is a few of the scene.
    assert abs(row - n_rows / 2) < 5
    assert abs(line - 64) < 5
    assert " ns two-way from the surface" in page.locator("#readout").inner_text()


def test_nothing_is_wider_than_the_screen(opened):
    widths = opened.page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    assert widths[0] <= widths[1]


def test_a_download_gives_the_table_s_bytes(opened, planted_tables, tmp_path):
    page = opened.page
    page.locator("#tables details").first.locator("summary").click()
    link = page.locator("#tables a.download").first
    with page.expect_download() as waiting:
        link.click()
    waiting.value.save_as(tmp_path / "table.csv")
    name = link.get_attribute("download")
    assert waiting.value.suggested_filename == name
    assert (tmp_path / "table.csv").read_bytes() == (planted_tables / name).read_bytes()
    assert len(list(csv.reader(io.StringIO((tmp_path / "table.csv").read_text())))) > 1


def test_a_figure_opens_large_and_escape_closes_it(opened):
    page = opened.page
    page.locator(".zoom").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("dialog img").evaluate("image => image.naturalWidth") > 0
    page.keyboard.press("Escape")
    page.locator("dialog").wait_for(state="detached", timeout=5000)


def test_headings_descend_one_level_at_a_time(opened):
    levels = opened.page.evaluate("[...document.querySelectorAll('h1,h2,h3,h4')].map(h => Number(h.tagName[1]))")
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in zip(levels, levels[1:], strict=False))


def test_what_is_focused_is_seen(opened):
    page = opened.page
    for _ in range(4):
        page.keyboard.press("Tab")
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline not in ("none", "")


@pytest.mark.parametrize(("option", "value"), [("color_scheme", "dark"), ("color_scheme", "light")])
def test_text_stands_out_from_its_page_in_both_schemes(browser, planted_page, option, value):
    opened = Opened(browser, planted_page, 1280, **{option: value})
    ink, paper = opened.page.evaluate(
        "['color', 'backgroundColor'].map(name => getComputedStyle(document.body)[name].match(/\\d+/g).map(Number))"
    )
    opened.context.close()
    # WCAG 2.1, 1.4.3 and 1.4.6: 4.5 is required, 7 is enhanced.
    assert contrast(ink, paper) > 7


def contrast(first, second):
    """Contrast ratio of two sRGB colours by WCAG 2.1."""

    def luminance(colour):
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (v / 255 for v in colour[:3])]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    high, low = sorted((luminance(first), luminance(second)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_the_page_prints_without_its_controls(browser, planted_page):
    opened = Opened(browser, planted_page, 1280)
    opened.page.emulate_media(media="print")
    assert opened.page.locator("nav").is_hidden()
    assert opened.page.locator("#panels .stage.observed img").is_visible()
    assert len(opened.page.pdf()) > 10_000
    opened.context.close()
