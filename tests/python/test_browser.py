"""The page in a browser: no errors, no sideways scrolling, a block that turns; at the widths of a desk and of a phone."""

import shutil
import subprocess
import sys

import pytest

import mesocrete as mc

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
# A machine without a graphics card draws in software.
SOFTWARE = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Opens a page at a width; closes the browser at the end."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright (pip install playwright)")
    if BROWSER is None:
        pytest.skip("needs chromium (Debian: apt install chromium)")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=SOFTWARE)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The page of a small periodic packing with voids and fibres: every section of it is there."""
    spec = {
        "specimen": {"kind": "cube", "side_mm": 50.0, "periodic": ["x", "y", "z"]},
        "fraction": 0.3,
        "voids": {"fraction": 0.01, "diameter_mm": [2.0, 3.0]},
        "fibres": {"fraction": 0.003, "length_mm": 15.0, "diameter_mm": 0.8},
    }
    path = tmp_path_factory.mktemp("page") / "model.html"
    # In a process of its own: the command takes Ctrl-C over for the rest of the process.
    command = [sys.executable, "-m", "mesocrete", "report", str(saved(spec, path)), "-o", str(path)]
    subprocess.run(command, check=True, capture_output=True)
    return path


def saved(spec, path):
    model = path.with_suffix(".json")
    mc.pack(spec, seed=1).write(model)
    return model


@pytest.mark.parametrize("width", [1280, 400])
def test_the_page_fits_turns_and_has_no_errors(pages, report, width):
    page = pages.new_page(viewport={"width": width, "height": 800})
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda asked: said.append(asked.url) if asked.url.startswith("http") else None)
    page.goto(report.as_uri())
    page.wait_for_timeout(500)
    assert page.evaluate("document.documentElement.scrollWidth") <= width, "the page scrolls sideways"
    canvas = page.locator("#view")
    canvas.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    box = canvas.bounding_box()
    assert box["width"] > 0.7 * width
    before = canvas.screenshot()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 80, middle[1] + 30, steps=4)
    page.mouse.up()
    page.wait_for_timeout(300)
    turned = canvas.screenshot()
    assert turned != before, "the block does not turn"
    for axis in "xyz":
        before = canvas.screenshot()
        page.locator(f"#cut-{axis}").evaluate("cut => { cut.value = 0.5; cut.dispatchEvent(new Event('input')); }")
        page.wait_for_timeout(300)
        assert canvas.screenshot() != before, f"the block is not cut along {axis}"
    with page.expect_download() as saved_picture:
        page.locator("#save").click()
    assert saved_picture.value.path().read_bytes().startswith(b"\x89PNG")
    assert page.locator(".key").count() >= 5, "the legend has every class, voids and fibres"
    # Drivers say on some machines that reading pixels stalls; that is no fault of the page.
    assert [text for text in said if "GPU stall" not in text] == []
    page.close()


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    """The page of a small test that softens: peak, 80 % after it, and the end."""
    folder = tmp_path_factory.mktemp("test")
    spec = "fraction = 0.3\n[specimen]\nkind = 'cube'\nside_mm = 30\n[grading]\nd_min_mm = 6\nd_max_mm = 12\n"
    (folder / "spec.toml").write_text(spec)
    flags = ["--element-size-mm", "3", "--accept-phase-error", "--frames", "0", "--control", "steady"]
    command = [sys.executable, "-m", "mesocrete", "solve", folder / "spec.toml", "-o", folder / "out", *flags]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "out" / "result.html"


BEAM = """fraction = 0.2
[specimen]
kind = 'notched-prism'
length_mm = 100
width_mm = 20
depth_mm = 24
notch_width_mm = 6
notch_depth_mm = 6
[grading]
d_min_mm = 6
d_max_mm = 9
"""
CUBE = "fraction = 0.2\n[specimen]\nkind = 'cube'\nside_mm = 20\n[grading]\nd_min_mm = 6\nd_max_mm = 9\n"


@pytest.fixture(scope="module", params=[("bending", BEAM, "1e-4"), ("expansion", CUBE, "1e-4")], ids=lambda test: test[0])
def named(request, tmp_path_factory):
    """The page of a named test of a few steps: only its form counts."""
    name, spec, strain = request.param
    folder = tmp_path_factory.mktemp(name)
    (folder / "spec.toml").write_text(spec)
    flags = ["--test", name, "--strain", strain, "--element-size-mm", "4", "--accept-phase-error", "--frames", "0"]
    command = [sys.executable, "-m", "mesocrete", "solve", folder / "spec.toml", "-o", folder / "out", *flags, "--control", "steady"]
    subprocess.run(command, check=True, capture_output=True)
    return name, folder / "out" / "result.html"


# The case: six empty plots of an expansion, "mean axial strain" of a beam, a section that filled the screen beside two
# stamps, and names of curves that lay on one another at 400 px.
APART = """() => [...document.querySelectorAll("svg")].every((plot) => {
  const names = [...plot.querySelectorAll("rect + text")].map((name) => name.getBoundingClientRect());
  const keys = [...plot.querySelectorAll("rect")].map((key) => key.getBoundingClientRect());
  return names.every((a) => keys.every((b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top));
})"""
HEIGHTS = "() => [...document.querySelectorAll('section[data-moment]:not([hidden]) img')].map((image) => image.getBoundingClientRect().height)"
WORDS = {
    "bending": ["A beam along x on two rollers", "load over crack mouth", "span", "strain 6 h w / l²"],
    "expansion": ["Expansion test: mean strain_x", "aggregate 1e-4", "time, ms", "strain_z"],
}


@pytest.mark.parametrize("width", [1280, 400])
def test_the_page_of_a_named_test_has_its_words_and_no_empty_plot(pages, named, width):
    name, path = named
    page = pages.new_page(viewport={"width": width, "height": 800})
    said = []
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(path.as_uri())
    page.wait_for_timeout(300)
    text = page.locator("main").inner_text() + " ".join(page.locator("svg text").all_text_contents())
    assert [words for words in WORDS[name] if words not in text] == []
    assert "nothing to show" not in text and "axial strain" not in text
    assert "0.00 MPa" not in page.title()
    assert page.evaluate("document.documentElement.scrollWidth") <= width, "the page scrolls sideways"
    assert page.evaluate(APART), "names of curves lie on one another"
    heights = page.evaluate(HEIGHTS)
    assert len(heights) == 3 and (width < 640 or max(heights) - min(heights) < 2), heights
    assert said == []
    page.close()


def drag(page, place, by):
    """Drags the mouse from `place`, in pixels of the window, by `by`."""
    page.mouse.move(*place)
    page.mouse.down()
    page.mouse.move(place[0] + by[0], place[1] + by[1], steps=4)
    page.mouse.up()
    page.wait_for_timeout(300)


def thumb(page, name):
    """The place of a slider's thumb, in pixels of the window, and the slider's width; brings it into view."""
    page.locator(name).scroll_into_view_if_needed()
    box = page.locator(name).bounding_box()
    share = page.locator(name).evaluate("s => s.max > 0 ? s.value / s.max : 0")
    return (box["x"] + 8 + share * (box["width"] - 16), box["y"] + box["height"] / 2), box["width"]


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (1280, "dark"), (400, "light"), (400, "dark")])
def test_the_page_of_a_test_follows_its_sliders(pages, tested, width, scheme):
    page = pages.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda asked: said.append(asked.url) if asked.url.startswith("http") else None)
    page.goto(tested.as_uri())
    page.wait_for_timeout(500)
    assert page.evaluate("document.documentElement.scrollWidth") <= width, "the page scrolls sideways"
    main = page.locator("main").bounding_box()
    assert main["width"] > 0.95 * width, "the page leaves its width empty"
    canvas, dot, told = page.locator("#cracks"), page.locator(".now"), page.locator("#told")
    canvas.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    assert told.inner_text().startswith("end: strain ")
    at_dot = "dot => [dot.cx.baseVal.value, dot.cy.baseVal.value]"
    end = dot.evaluate(at_dot)
    at_the_end = canvas.screenshot()
    place, wide = thumb(page, "#moment")
    drag(page, place, (-2 * wide, 0))
    assert told.inner_text().startswith("peak: strain ")
    peak = dot.evaluate(at_dot)
    assert peak[0] < end[0] and peak[1] < end[1], "the dot does not follow the slider"
    at_the_peak = canvas.screenshot()
    assert at_the_peak != at_the_end, "the body does not follow the slider"
    shown = page.locator("section[data-moment]:visible h2").all_inner_texts()
    assert len(shown) == 1 and shown[0].startswith("Damage: peak, "), shown
    place, wide = thumb(page, "#factor")
    drag(page, place, (wide / 3, 0))
    deformed = canvas.screenshot()
    assert deformed != at_the_peak, "the body does not deform"
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    drag(page, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 3), (60, 20))
    assert canvas.screenshot() != deformed, "the body does not turn"
    # Names of curves lie above their axes.
    above = """() => [...document.querySelectorAll("svg")].every((plot) => {
      const top = plot.querySelector(".f").getBoundingClientRect().top;
      return [...plot.querySelectorAll("rect + text")].every((name) => name.getBoundingClientRect().bottom <= top + 1);
    })"""
    assert page.evaluate(above), "a name lies on a curve"
    assert [text for text in said if "GPU stall" not in text] == []
    page.close()
