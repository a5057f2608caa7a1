"""The paper for a journal of software: every citation has an entry, and it builds where pandoc is installed."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

PAPER = Path(__file__).resolve().parents[2] / "paper"


def test_every_citation_has_an_entry_and_every_entry_is_cited():
    cited = set(re.findall(r"@(\w+)", (PAPER / "paper.md").read_text(encoding="utf-8")))
    entries = set(re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE))
    assert cited == entries and len(entries) > 10


def test_the_paper_has_the_sections_that_the_journal_asks_for():
    text = (PAPER / "paper.md").read_text(encoding="utf-8")
    headings = re.findall(r"^# (.*)$", text, re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field", "References"} <= set(headings)
    assert 250 <= len(text.split()) <= 1750


def test_the_paper_builds(tmp_path):
    pandoc = shutil.which("pandoc")
    if pandoc is None:
        pypandoc = pytest.importorskip("pypandoc", reason="needs pandoc (Debian: apt install pandoc)")
        pandoc = pypandoc.get_pandoc_path()
    out = tmp_path / "paper.html"
    build = [pandoc, "paper.md", "--citeproc", "--standalone", "--bibliography=paper.bib", "-o", str(out)]
    run = subprocess.run(build, cwd=PAPER, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    assert "State of the field" in out.read_text(encoding="utf-8")
