"""The site: every page of the gallery runs, every link leads somewhere."""

import ast
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mesocrete as mc
from mesocrete import _types

ROOT = Path(__file__).resolve().parents[2]
GALLERY = sorted((ROOT / "site" / "gallery").rglob("*.py"))
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def builder():
    """Import the program that builds the site."""
    path = ROOT / "site" / "build.py"
    build = importlib.util.module_from_spec(spec := importlib.util.spec_from_file_location("build", path))
    sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(build)
    finally:
        sys.path.remove(str(path.parent))
    return build


def public_names():
    """Every public name by its place in the reference, with what it is: `mc.x`, `mc.gjk.x`, and the members of classes."""
    for owner, prefix in ((mc, ""), (mc.gjk, "gjk.")):
        for name in set(owner.__all__) - {"__version__", "gjk"}:
            found = getattr(owner, name)
            yield f"{prefix}{name}", found
            if isinstance(found, type) and not issubclass(found, tuple):
                yield from ((f"{name}.{member}", value) for member, value in vars(found).items() if not member.startswith("_"))


def test_every_public_name_has_a_docstring_a_page_of_the_reference_and_a_test():
    pages = [name for _, _, objects in builder().reference.pages().values() for name in objects]
    tests = "".join(path.read_text(encoding="utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    names = dict(public_names())
    assert len(names) > 100
    assert [name for name, found in names.items() if not getattr(found, "__doc__", None)] == []
    # A page has a class with all its members.
    assert sorted(set(names) - {name.removeprefix("mesocrete.") for name in pages} - {n for n in names if "." in n and n[0].isupper()}) == []
    assert len(pages) == len(set(pages))
    assert [name for name in names if not re.search(rf"\b{re.escape(name.rpartition('.')[2])}\b", tests)] == []


def test_a_dict_of_the_reference_has_a_row_for_every_key():
    text = builder().reference.keys("mesocrete._types.MeshOptions")
    assert text.startswith("## MeshOptions") and "| `itz` | `Literal[" in text
    assert len(re.findall(r"^\| `", text, re.MULTILINE)) == len(_types.MeshOptions.__annotations__)


# The case: `**mc.Test.triaxial(10.0)` had 13 errors of types, and a wrong keyword none. A strict run refuses each
# `type: ignore` that is not needed.
TESTS = """import mesocrete as mc
mesh = mc.pack().mesh()
mesh.solve(**mc.Test.triaxial(10.0), threads=2)
mesh.solve(mc.Test.cyclic([(0.001, "strain"), (1.0, "stress")]), law="meso")
mesh.solve(test=mc.Test.expansion(aggregate=1e-4, itz=0.0))
mesh.write("deck.inp", test=mc.Test.biaxial(0.5, friction=0.005))
mc.Test.triaxial(pressure=10.0)  # type: ignore[call-arg]
mc.Test.cyclic([(0.001, "strian")])  # type: ignore[list-item]
mc.Test.tension(control="stedy")  # type: ignore[arg-type]
mesh.solve(test="twisting")  # type: ignore[arg-type]
"""


@pytest.mark.slow
def test_examples_and_pages_pass_mypys_strict_mode(tmp_path):
    pytest.importorskip("mypy")
    tests = tmp_path / "tests.py"
    tests.write_text(TESTS)
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), "--scripts-are-modules"]
    # pyvista, matplotlib and scipy may be absent, or without types.
    scripts = ["--ignore-missing-imports", *map(str, EXAMPLES), *map(str, GALLERY), str(tests)]
    run = subprocess.run([*mypy, *scripts], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr



def test_the_gallery_has_a_dozen_pages_with_titles_and_pictures():
    assert len(GALLERY) >= 12
    for script in GALLERY:
        source = script.read_text(encoding="utf-8")
        title = (ast.get_docstring(ast.parse(source)) or "").splitlines()[0]
        assert title, script.name
        assert "picture.png" in source, script.name


def test_a_page_becomes_a_notebook_of_the_same_code():
    """Its cells, joined, are the program but for the comments that became text."""
    build = builder()
    for script in GALLERY:
        source = script.read_text(encoding="utf-8")
        parts = build.cells(source.split('"""', 2)[2].strip())
        notebook = json.loads(build.notebook(parts))
        code = "\n".join(cell["source"] for cell in notebook["cells"] if cell["cell_type"] == "code")
        assert ast.dump(ast.parse(code)) == ast.dump(ast.parse(source.split('"""', 2)[2])), script.name
        assert build.markdown(parts).count("```python") == sum(cell["cell_type"] == "code" for cell in notebook["cells"])


def test_every_page_is_in_the_navigation():
    config = (ROOT / "site" / "mkdocs.yml").read_text(encoding="utf-8")
    pages = {path.name for folder in ("docs", "docs/measured", "site/pages") for path in (ROOT / folder).glob("*.md")}
    pages |= {"benchmark.md", *builder().ROOT_PAGES.values()}
    assert pages == set(re.findall(r"[\w-]+\.md", config))
    assert "# GALLERY" in config and "# REFERENCE" in config, "the pages that are written have their places"


SITE_PAGES = ["from-a-sieve-table.md", "other-solvers.md"]


@pytest.mark.parametrize("page", SITE_PAGES)
def test_the_commands_of_a_page_run_in_their_order(run, tmp_path, page):
    """The pages are what a newcomer types; commands whose comment ends in "minutes" are left out."""
    text = (ROOT / "site" / "pages" / page).read_text(encoding="utf-8")
    if table := re.search(r"```text\n(sieve.*?)```", text, re.DOTALL):
        (tmp_path / "sieves.csv").write_text(table[1], encoding="utf-8")
    commands = 0
    for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
        for line in block.splitlines():
            words = line.partition("#")[0].split()
            if words[:1] != ["mesocrete"] or line.endswith("minutes"):
                continue
            process = run(*words[1:])
            assert process.returncode == 0, (line, process.stderr)
            commands += 1
            if words[1] == "init" and (toml := re.search(r"```toml\n\[grading\]\n(.*?)```", text, re.DOTALL)):
                spec = tmp_path / words[-1]
                new = re.sub(r"\[grading\]\n.*?(?=\n\[|\Z)", "[grading]\n" + toml[1], spec.read_text(encoding="utf-8"), count=1, flags=re.DOTALL)
                assert "sieves.csv" in new
                spec.write_text(new, encoding="utf-8")
    assert commands >= 3


@pytest.mark.slow
def test_the_site_builds_without_a_warning():
    for library in ("mkdocs", "material", "mkdocstrings_handlers", "pyvista", "matplotlib", "scipy"):
        pytest.importorskip(library)
    build = [sys.executable, str(ROOT / "site" / "build.py")]
    run = subprocess.run(build, capture_output=True, text=True, timeout=1800, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "WARNING" not in run.stderr


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_of_the_site_fit_a_desk_and_a_phone(width, scheme):
    """No sideways scroll, no page beyond 10,000 px at a desk, no error in the console. Runs on the site that was built."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright (pip install playwright)")
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    pages = sorted(set((ROOT / "build" / "site").rglob("*.html")) - {ROOT / "build" / "site" / "404.html"})
    if browser is None or not pages:
        pytest.skip("needs chromium and a built site (python3 site/build.py)")
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = opened.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
        said = []
        page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: said.append(str(error)))
        for path in pages:
            page.goto(path.as_uri())
            wide, high = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
            assert wide <= width, f"{path.name} scrolls sideways"
            assert width < 1280 or high <= 10_000, f"{path.name} is {high} px high"
        opened.close()
    # A page from a file may not fetch the search index.
    assert [text for text in said if "CORS" not in text and "file:" not in text] == []
