"""The README's examples run as they stand, and its links lead somewhere."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "site"))
import links  # noqa: E402

UNREAD = {"target", ".venv", ".pytest_cache", "build", "shared"}
PAGES = [path for path in sorted(ROOT.rglob("*.md")) if not UNREAD & set(path.relative_to(ROOT).parts)]


# Words of the Python example, and what makes it a matter of seconds; it runs as it stands in the slow tier.
SHORTER = {"[60, 60, 120]": "[40, 40, 40]", "solve(friction=0.1)": "solve(friction=0.1, strain=0.0005)"}


@pytest.mark.parametrize("words", [pytest.param({}, marks=pytest.mark.slow, id="whole"), pytest.param(SHORTER, id="short")])
def test_the_python_example_runs(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for old, new in words.items():
        assert readme.count(old) == 1
        readme = readme.replace(old, new)
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})
    assert "target-reached" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"model.vtu", "mesh.inp"}


def commands_of_the_readme():
    """Split the README's commands into those of a moment and those whose comment ends in "minutes"."""
    blocks = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines() if line.startswith("mesocrete ")]
    moments = [line for line in lines if not line.endswith("minutes")]
    words = [[line.partition("#")[0].split()[1:] for line in kind] for kind in (moments, lines)]
    return words[0], [command for command in words[1] if command not in words[0]]


def test_the_commands_run(run, tmp_path):
    """In a specimen of 40 mm, which takes seconds; as they stand in the slow tier."""
    commands, _ = commands_of_the_readme()
    assert len(commands) >= 4
    for command in commands:
        small = command if "SPEC.toml" in command or command[0] != "pack" else ["pack", "SPEC.toml", *command[1:]]
        process = run(*small)
        assert process.returncode == 0, (small, process.stderr)
        if command == ["init"]:
            spec = (tmp_path / "SPEC.toml").read_text(encoding="utf-8")
            assert "side_mm = 150" in spec
            (tmp_path / "SPEC.toml").write_text(spec.replace("side_mm = 150", "side_mm = 40"), encoding="utf-8")
    assert {"SPEC.toml", "model.json", "mesh.inp"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.slow
def test_the_commands_run_as_they_stand(run, tmp_path):
    for command in [command for kind in commands_of_the_readme() for command in kind]:
        process = run(*command, timeout=1800)
        assert process.returncode == 0, (command, process.stderr)
    assert (tmp_path / "out" / "result.html").exists()


def test_no_link_of_the_repository_is_dead():
    """The case: 31 links of site/pages were right only on the built site."""
    assert len(PAGES) > 30
    assert {str(page.relative_to(ROOT)): found for page in PAGES if (found := links.dead_in_repository(page))} == {}


def test_dead_links_are_seen_in_markdown_and_in_raw_html(tmp_path):
    (tmp_path / "a.md").write_text("[a](a.md#x) [b](gone.md) [![p](a.md)](lost.md) [web](https://x.org)\n```\n[c](code.md)\n```\n")
    assert links.dead_in_repository(tmp_path / "a.md") == ["gone.md", "lost.md"]
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.html").write_text('<a href="changelog.html">x</a><a href="../b.html#y">y</a><img src="//x.org/p">')
    (tmp_path / "b.html").write_text('<a href="in/a.html?q=1">x</a>')
    assert links.dead(tmp_path) == ["in/a.html: changelog.html"]


def test_links_of_the_sites_pages_lead_to_its_pages(tmp_path):
    """A link to a document of the repository becomes one to its page; a gallery's picture is put in."""
    page = links.ROOT / "site" / "pages" / "learning.md"
    (tmp_path / "learning.md").write_text(page.read_text(encoding="utf-8"), encoding="utf-8")
    script = links.ROOT / "site" / "gallery" / "08_data_set.py"
    sources = {"learning.md": page, "images.md": links.ROOT / "docs" / "images.md", "gallery/08_data_set.md": script}
    links.repository_links(tmp_path, sources, None)
    text = (tmp_path / "learning.md").read_text(encoding="utf-8")
    assert "](images.md)" in text and "](gallery/08_data_set.md)" in text and "](gallery/08_data_set/picture.png)" in text
    assert "Studies (`docs/studies.md`)" in text and "](../" not in text
