"""The site: every page of the gallery runs, every link leads somewhere."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import mesocrete as mc

ROOT = Path(__file__).resolve().parents[2]
GALLERY = sorted((ROOT / "site" / "gallery").glob("*.py"))
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def builder():
    """Import the program that builds the site."""
    path = ROOT / "site" / "build.py"
    build = importlib.util.module_from_spec(spec := importlib.util.spec_from_file_location("build", path))
    spec.loader.exec_module(build)
    return build


def public_names():
    """Every public name by its place in the reference, with what it is: `mc.x`, `mc.gjk.x`, and the members of classes."""
    for owner, prefix in ((mc, ""), (mc.gjk, "gjk.")):
        for name in set(owner.__all__) - {"__version__", "gjk"}:
            found = getattr(owner, name)
            yield f"{prefix}{name}", found
            if isinstance(found, type) and not issubclass(found, tuple):
                yield from ((f"{name}.{member}", value) for member, value in vars(found).items() if not member.startswith("_"))


def test_every_public_name_has_a_docstring_a_line_in_the_reference_and_a_test():
    headings = set(re.findall(r"^##+ (.*)$", builder().reference(), re.MULTILINE))
    tests = "".join(path.read_text(encoding="utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    names = dict(public_names())
    assert len(names) > 100
    assert [name for name, found in names.items() if not getattr(found, "__doc__", None)] == []
    assert sorted(set(names) - headings) == []
    assert [name for name in names if not re.search(rf"\b{re.escape(name.rpartition('.')[2])}\b", tests)] == []


@pytest.mark.slow
def test_examples_and_pages_pass_mypys_strict_mode(tmp_path):
    pytest.importorskip("mypy")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), "--scripts-are-modules"]
    # pyvista, matplotlib and scipy may be absent, or without types.
    scripts = ["--ignore-missing-imports", *map(str, EXAMPLES), *map(str, GALLERY)]
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
    pages = {path.name for folder in ("docs", "site/pages") for path in (ROOT / folder).glob("*.md")}
    named = set(re.findall(r"[\w-]+\.md", config)) - {"reference.md"}
    assert pages == named


@pytest.mark.slow
def test_the_site_builds_without_a_warning():
    for library in ("mkdocs", "material", "pyvista", "matplotlib", "scipy"):
        pytest.importorskip(library)
    build = [sys.executable, str(ROOT / "site" / "build.py")]
    run = subprocess.run(build, capture_output=True, text=True, timeout=1800, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "WARNING" not in run.stderr
