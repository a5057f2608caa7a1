#!/usr/bin/env python3
"""Builds the site: runs every page of the gallery, writes it as page and notebook, the reference from the stub, and has
mkdocs check all links.

python3 site/build.py            into build/site; warnings are errors
python3 site/build.py --only 05  runs one page of the gallery and nothing else
python3 site/build.py --keep     reuses the pages of the gallery that an earlier build wrote

MESOCRETE_REPOSITORY, an address, adds links to the source.

A page of the gallery is a Python file: its docstring is the title and the introduction, its comments at the left margin that
begin a paragraph are text, the rest is code. It runs in a folder of its own and writes `picture.png`.
"""

import argparse
import ast
import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import reference
from links import dead, repository_links

SITE = Path(__file__).resolve().parent
ROOT = SITE.parent
BUILD = ROOT / "build"
PAGES = BUILD / "docs"
GALLERY = BUILD / "gallery"
# Documents at the root of the repository that are pages, too.
ROOT_PAGES = {f"{name.upper()}.md": f"{name}.md" for name in ("changelog", "architecture", "contributing", "security")}


def main() -> None:
    """Run the steps in order."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", help="run the pages whose name begins so")
    parser.add_argument("--keep", action="store_true", help="reuse the pages of the gallery of an earlier build")
    arguments = parser.parse_args()
    if not arguments.keep:
        shutil.rmtree(GALLERY, ignore_errors=True)
    scripts = sorted((SITE / "gallery").rglob("*.py"), key=lambda script: script.stem)
    shown = [gallery_page(script) for script in scripts if script.stem.startswith(arguments.only or "")]
    if arguments.only:
        return
    copy_pages()
    (PAGES / "gallery" / "index.md").write_text(gallery_index(shown), encoding="utf-8")
    entries = {"GALLERY": [(title, f"gallery/{name}.md") for name, title, _ in shown], "REFERENCE": reference.write(PAGES / "reference")}
    repository_links(PAGES, sources(), os.environ.get("MESOCRETE_REPOSITORY"))
    (BUILD / "mkdocs.yml").write_text(configuration(entries), encoding="utf-8")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--clean", "--config-file", str(BUILD / "mkdocs.yml")]
    subprocess.run(command, check=True, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"})
    # mkdocs sees the links of Markdown alone.
    if found := dead(BUILD / "site"):
        sys.exit("\n".join(["dead links of the site:", *found]))


def copy_pages() -> None:
    """Lay the documents, the site's own pages and the gallery into one folder."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "docs", PAGES, ignore=shutil.ignore_patterns("*.py", "*.toml", "README.md", "experiments"))
    shutil.copytree(SITE / "pages", PAGES, dirs_exist_ok=True)
    shutil.copytree(GALLERY, PAGES / "gallery")
    for document, page in ROOT_PAGES.items():
        shutil.copy(ROOT / document, PAGES / page)
    (PAGES / "benchmark.md").write_text(benchmark(), encoding="utf-8")
    (PAGES / "results").mkdir()
    for plot in (ROOT / "benches" / "results").glob("*.svg"):
        shutil.copy(plot, PAGES / "results")


def sources() -> dict[str, Path]:
    """Map the pages of the site to the files of the repository that they are."""
    found = {path.relative_to(folder).as_posix(): path for folder in (ROOT / "docs", SITE / "pages") for path in folder.rglob("*") if path.suffix != ".py"}
    found |= {page: ROOT / document for document, page in ROOT_PAGES.items()} | {"benchmark.md": ROOT / "benchmark" / "README.md"}
    found |= {f"results/{plot.name}": plot for plot in (ROOT / "benches" / "results").glob("*.svg")}
    found |= {f"gallery/{script.stem}.md": script for script in (SITE / "gallery").rglob("*.py")}
    return found | {"gallery/index.md": SITE / "gallery", "reference/index.md": SITE / "reference.py"}


def benchmark() -> str:
    """Return the page of the benchmark with its table of results."""
    with (ROOT / "benchmark" / "results.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    lines = ["| " + " | ".join(row).replace("_", " ") + " |" for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return (ROOT / "benchmark" / "README.md").read_text(encoding="utf-8").replace("<!-- results -->", "\n".join(lines))


def version() -> str:
    """Read the version of the workspace."""
    return re.search(r'^version = "([^"]+)"', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]


def configuration(entries: dict[str, list[tuple[str, str]]]) -> str:
    """Return mkdocs' configuration with the version and the entries of written pages."""
    text = (SITE / "mkdocs.yml").read_text(encoding="utf-8").replace("@VERSION@", version())
    for mark, pages in entries.items():
        lines = [f"      - {json.dumps(title)}: {page}" for title, page in pages]
        text = text.replace(f"      # {mark}", "\n".join(lines))
    return text


def gallery_page(script: Path) -> tuple[str, str, str]:
    """Run a page, write it with its output and picture; return its file, title and introduction."""
    folder = GALLERY / script.stem
    docstring = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
    title, _, text = docstring.partition("\n")
    if not (GALLERY / f"{script.stem}.md").exists():
        run_page(script, folder, title, text.strip())
    return script.stem, title, text.strip()


def run_page(script: Path, folder: Path, title: str, text: str) -> None:
    """Run a page in a folder; write it with its output, its picture and its notebook."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    environment = os.environ | {"MPLBACKEND": "Agg", "PYVISTA_OFF_SCREEN": "true"}
    run = subprocess.run([sys.executable, str(script)], cwd=folder, env=environment, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{script.name} failed:\n{run.stdout}{run.stderr}")
    source = script.read_text(encoding="utf-8")
    parts = cells(source.split('"""', 2)[2].strip())
    output = f"\nIt prints:\n\n```text\n{run.stdout.rstrip()}\n```\n" if run.stdout else ""
    picture = f"\n![{title}]({script.stem}/picture.png)\n" if (folder / "picture.png").exists() else ""
    if not picture:
        sys.exit(f"{script.name} wrote no picture.png")
    download = f"\n[This page as a notebook]({script.stem}/{script.stem}.ipynb)\n"
    page = f"# {title}\n\n{text}\n{picture}\n{markdown(parts)}{output}{download}"
    (GALLERY / f"{script.stem}.md").write_text(page, encoding="utf-8")
    for left in folder.iterdir():
        if left.name != "picture.png":
            shutil.rmtree(left) if left.is_dir() else left.unlink()
    introduction = ("markdown", f"# {title}\n\n{text}")
    (folder / f"{script.stem}.ipynb").write_text(notebook([introduction, *parts]), encoding="utf-8")
    print(f"ran {script.name}", flush=True)


def cells(code: str) -> list[tuple[str, str]]:
    """Divide a program: ("markdown", text) of the comments that begin a paragraph, ("code", lines) of the rest."""
    found: list[tuple[str, str]] = []
    block: list[str] = []
    prose: list[str] = []

    def end(kind: str, text: str) -> None:
        if text:
            found.append((kind, text))

    lines = ["", *code.splitlines()]
    for before, line in zip(lines, lines[1:], strict=False):
        if line.startswith("# ") and (not before.strip() or prose):
            if not prose:
                end("code", "\n".join(block).strip("\n"))
                block.clear()
            prose.append(line[2:])
            continue
        end("markdown", " ".join(prose))
        prose.clear()
        block.append(line)
    end("code", "\n".join(block).strip("\n"))
    return found


def markdown(parts: list[tuple[str, str]]) -> str:
    """Write the cells of a program as a page."""
    return "\n".join(f"```python\n{text}\n```\n" if kind == "code" else f"{text}\n" for kind, text in parts)


def notebook(parts: list[tuple[str, str]]) -> str:
    """Write the cells of a program as a Jupyter notebook (format 4.5)."""
    code = {"execution_count": None, "outputs": []}
    made = [
        {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text} | (code if kind == "code" else {})
        for number, (kind, text) in enumerate(parts)
    ]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return json.dumps({"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}, indent=1)


def gallery_index(pages: list[tuple[str, str, str]]) -> str:
    """Write the front page of the gallery: a card for every page."""
    cards = [
        f"-   [![{title}]({name}/picture.png)]({name}.md)\n\n    **[{title}]({name}.md)**\n\n    {first_sentence(text)}\n"
        for name, title, text in pages
    ]
    intro = "Every page is a program that runs when this site is built. Copy it, or take its notebook, and change it."
    return f"---\nhide: [toc]\n---\n# Gallery\n\n{intro}\n\n<div class=\"grid cards\" markdown>\n\n" + "\n".join(cards) + "\n</div>\n"


def first_sentence(text: str) -> str:
    """Return the first sentence of an introduction, without its links."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text.replace("\n", " "))
    return re.split(r"(?<=[.:?])\s", plain)[0].rstrip(":")


if __name__ == "__main__":
    main()
