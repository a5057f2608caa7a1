"""The site: every page of the gallery runs, every link leads somewhere."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GALLERY = sorted((ROOT / "site" / "gallery").glob("*.py"))


def test_the_gallery_has_a_dozen_pages_with_titles_and_pictures():
    assert len(GALLERY) >= 12
    for script in GALLERY:
        source = script.read_text(encoding="utf-8")
        title = (ast.get_docstring(ast.parse(source)) or "").splitlines()[0]
        assert title, script.name
        assert "picture.png" in source, script.name


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
    reference = (ROOT / "build" / "docs" / "reference.md").read_text(encoding="utf-8")
    import mesocrete as mc

    for name in set(mc.__all__) - {"__version__", "gjk"}:
        assert re.search(rf"^## {name}$", reference, re.MULTILINE), name
