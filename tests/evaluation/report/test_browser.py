"""The report in a real browser: it opens, pictures decode, the gallery lives, it fits a phone."""

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
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as session:
        chromium = session.chromium.launch(
            executable_path=str(CHROMIUM), args=["--disable-gpu", "--disable-quic"]
        )
        yield chromium
        chromium.close()


@pytest.fixture
def open_page(browser, planted_page):
    """A function that opens the report in a window of some width."""
    contexts = []

    def opened(width, **options):
        contexts.append(browser.new_context(viewport={"width": width, "height": 800}, **options))
        page = contexts[-1].new_page()
        page.goto(planted_page.as_uri(), wait_until="load")
        return page

    yield opened
    for context in contexts:
        context.close()


@pytest.fixture(params=[1280, 360], ids=["desktop", "phone"])
def page(open_page, request):
    return open_page(request.param)


def test_the_page_opens_without_errors_or_requests(page, planted_page):
    messages, requests = [], []
    page.on("console", lambda message: messages.append(message.text))
    page.on("pageerror", lambda error: messages.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.reload(wait_until="load")
    page.wait_for_timeout(200)
    assert messages == []
    assert [url for url in requests if not url.startswith("data:")] == [planted_page.as_uri()]


def test_every_image_of_every_scene_decodes_and_has_alt_text(page):
    n_scenes = page.locator("#scene option").count()
    assert n_scenes > 0
    for scene in range(n_scenes):
        page.select_option("#scene", str(scene))
        page.evaluate("Promise.all([...document.images].map(image => image.decode()))")
        bad = page.evaluate(
            "[...document.images].filter(i => !(i.naturalWidth > 0) || !i.alt.trim())"
            ".map(i => i.src.slice(0, 60))"
        )
        assert bad == []


def test_the_layer_switch_shows_and_hides_layers(page):
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
    return tuple(
        int(number) for number in re.match(r"range bin (\d+), range line (\d+)", text).groups()
    )


def test_the_depth_cursor_moves_by_keyboard(page):
    row, line = place(page)
    page.focus("#readout")
    moves = [
        ("ArrowDown", 1, 0),
        ("PageDown", 11, 0),
        ("ArrowUp", 10, 0),
        ("ArrowLeft", 10, -1),
        ("PageUp", 0, -1),
    ]
    for key, rows, lines in moves:
        page.keyboard.press(key)
        assert place(page) == (row + rows, line + lines)
    page.keyboard.press("Home")
    assert place(page)[0] == 0
    page.keyboard.press("ArrowUp")
    assert place(page)[0] == 0
    page.keyboard.press("End")
    readout = page.locator("#readout")
    assert (
        place(page)[0]
        == int(readout.get_attribute("aria-valuemax"))
        == int(readout.get_attribute("aria-valuenow"))
    )
    for cursor in page.locator("#panels .cursor.across").all():
        assert float(cursor.get_attribute("y1")) == place(page)[0]


def test_the_depth_cursor_follows_the_pointer(page):
    stage = page.locator("#panels .stage.observed")
    stage.scroll_into_view_if_needed()
    box = stage.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    n_rows = int(page.locator("#readout").get_attribute("aria-valuemax")) + 1
    row, line = place(page)
    # A pixel of the screen is a few of the scene.
    assert abs(row - n_rows / 2) < 5
    assert abs(line - 64) < 5
    readout = page.locator("#readout").inner_text()
    delay_ns = float(re.search(r"([\d.-]+) ns two-way from the surface", readout)[1])
    depth_m = float(re.search(r"([\d.]+) m deep in snow", readout)[1])
    # Snow of 340 kg m-3; rounded to 0.1 ns and 1 cm.
    assert abs(depth_m - 0.299792458 * delay_ns / (2 * 1.2873)) < 0.02


def test_nothing_is_wider_than_the_screen(page):
    widths = page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    assert widths[0] <= widths[1]


def test_a_download_gives_the_table_s_bytes(page, planted_tables, tmp_path):
    page.locator("#tables details").first.locator("summary").click()
    link = page.locator("#tables a.download").first
    with page.expect_download() as waiting:
        link.click()
    waiting.value.save_as(tmp_path / "table.csv")
    name = link.get_attribute("download")
    assert waiting.value.suggested_filename == name
    assert (tmp_path / "table.csv").read_bytes() == (planted_tables / name).read_bytes()


def test_a_figure_opens_large_and_escape_closes_it(page):
    page.locator(".zoom").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("dialog img").evaluate("image => image.naturalWidth") > 0
    page.keyboard.press("Escape")
    page.locator("dialog").wait_for(state="detached", timeout=5000)


def test_headings_descend_one_level_at_a_time(page):
    levels = page.evaluate(
        "[...document.querySelectorAll('h1,h2,h3,h4')].map(h => Number(h.tagName[1]))"
    )
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in zip(levels, levels[1:], strict=False))


def test_what_is_focused_is_seen(page):
    for _ in range(4):
        page.keyboard.press("Tab")
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline not in ("none", "")


def luminance(colour):
    """Of an sRGB colour by WCAG 2.1."""
    linear = [
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        for c in (v / 255 for v in colour[:3])
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_text_stands_out_from_its_page_in_both_schemes(open_page, scheme):
    colours = open_page(1280, color_scheme=scheme).evaluate(
        "['color', 'backgroundColor'].map("
        "name => getComputedStyle(document.body)[name].match(/\\d+/g).map(Number))"
    )
    low, high = sorted(map(luminance, colours))
    # WCAG 2.1, 1.4.3 and 1.4.6: 4.5 is required, 7 is enhanced.
    assert (high + 0.05) / (low + 0.05) > 7


def test_the_page_prints_without_its_controls(open_page):
    page = open_page(1280)
    page.emulate_media(media="print")
    assert page.locator("nav").is_hidden()
    assert page.locator("#panels .stage.observed img").is_visible()
    assert len(page.pdf()) > 10_000
