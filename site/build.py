#!/usr/bin/env python3
"""Builds the site: runs every page of the gallery, writes it as page and notebook, the reference from the stub, and has
mkdocs check all links.

python3 site/build.py            into build/site; warnings are errors
python3 site/build.py --only 05  runs one page of the gallery and nothing else

A page of the gallery is a Python file: its docstring is the title and the introduction, its comments at the left margin that
begin a paragraph are text, the rest is code. It runs in a folder of its own and writes `picture.png`.
"""

import argparse
import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

SITE = Path(__file__).resolve().parent
ROOT = SITE.parent
BUILD = ROOT / "build"
PAGES = BUILD / "docs"
STUB = ROOT / "crates" / "meso-py" / "python" / "mesocrete" / "_mesocrete.pyi"
GJK = STUB.with_name("gjk.py")
MODULES = [STUB, GJK, *(STUB.with_name(name) for name in ("_options.py", "_study.py", "_results.py"))]


def main() -> None:
    """Run the steps in order."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", help="run the pages whose name begins so")
    only = parser.parse_args().only
    scripts = sorted((SITE / "gallery").glob("*.py"))
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "docs", PAGES, ignore=shutil.ignore_patterns("*.py", "*.toml"))
    shutil.copytree(SITE / "pages", PAGES, dirs_exist_ok=True)
    shown = [gallery_page(script) for script in scripts if not only or script.stem.startswith(only)]
    if only:
        return
    (PAGES / "gallery" / "index.md").write_text(gallery_index(shown), encoding="utf-8")
    (PAGES / "reference.md").write_text(reference(), encoding="utf-8")
    repository_links(PAGES)
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--clean", "--config-file", str(SITE / "mkdocs.yml")]
    subprocess.run(command, check=True, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"})


def gallery_page(script: Path) -> tuple[str, str]:
    """Run a page, write it with its output and picture; its file and title."""
    folder = PAGES / "gallery" / script.stem
    folder.mkdir(parents=True)
    environment = os.environ | {"MPLBACKEND": "Agg", "PYVISTA_OFF_SCREEN": "true"}
    run = subprocess.run([sys.executable, str(script)], cwd=folder, env=environment, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{script.name} failed:\n{run.stdout}{run.stderr}")
    source = script.read_text(encoding="utf-8")
    docstring = ast.get_docstring(ast.parse(source)) or ""
    title, _, text = docstring.partition("\n")
    parts = cells(source.split('"""', 2)[2].strip())
    output = f"\nIt prints:\n\n```text\n{run.stdout.rstrip()}\n```\n" if run.stdout else ""
    picture = f"\n![{title}]({script.stem}/picture.png)\n" if (folder / "picture.png").exists() else ""
    if not picture:
        sys.exit(f"{script.name} wrote no picture.png")
    download = f"\n[This page as a notebook]({script.stem}/{script.stem}.ipynb)\n"
    page = f"# {title}\n\n{text.strip()}\n{picture}\n{markdown(parts)}{output}{download}"
    (PAGES / "gallery" / f"{script.stem}.md").write_text(page, encoding="utf-8")
    for left in folder.iterdir():
        if left.name != "picture.png":
            shutil.rmtree(left) if left.is_dir() else left.unlink()
    introduction = ("markdown", f"# {title}\n\n{text.strip()}")
    (folder / f"{script.stem}.ipynb").write_text(notebook([introduction, *parts]), encoding="utf-8")
    print(f"ran {script.name}", flush=True)
    return script.stem, title


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


def gallery_index(pages: list[tuple[str, str]]) -> str:
    """Write the front page of the gallery."""
    cells = [f"- [![{title}]({name}/picture.png){{ width=240 }}]({name}.md)\n\n    [{title}]({name}.md)\n" for name, title in pages]
    intro = "Every page is a program that runs when this site is built. Copy it, or take its notebook, and change it."
    return f"# Gallery\n\n{intro}\n\n" + "\n".join(cells)


def reference() -> str:
    """Write the reference: every public name of the stub and the modules, with its signature and docstring."""
    text = ["# Reference\n", "The names of `import mesocrete as mc`. Lengths are in mm, stresses in MPa.\n"]
    in_gjk, own_of_gjk = gjk_names()
    for module in MODULES:
        for node in ast.parse(module.read_text(encoding="utf-8")).body:
            name = getattr(node, "name", "_")
            # Of what the compiled module returns plainly, gjk makes named tuples.
            if name.startswith("_") or (module == STUB and name in own_of_gjk):
                continue
            place = f"gjk.{name}" if name in in_gjk else name
            if isinstance(node, ast.ClassDef):
                text += [f"## {place}\n", doc(node)]
                items = [item for item in node.body if is_public(item)]
                # Of overloads the first has the docstring.
                text += [entry(b, node.name) for a, b in zip([None, *items], items) if not (a and a.name == b.name)]
                text += fields(node)
            elif isinstance(node, ast.FunctionDef):
                text.append(entry(node, "").replace(f"## {name}\n", f"## {place}\n", 1))
    return "\n".join(text)


def gjk_names() -> tuple[set[str], set[str]]:
    """Find the public names of `mesocrete.gjk`, and those that the module itself defines."""
    body = ast.parse(GJK.read_text(encoding="utf-8")).body
    own = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    listed = next(node.value for node in body if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    return set(ast.literal_eval(listed)), own


def fields(node: ast.ClassDef) -> list[str]:
    """Write the keys of a dict's type."""
    keys = [
        f"- `{key.target.id}`: `{ast.unparse(key.annotation)}`. {ast.literal_eval(text.value)}"
        for key, text in zip(node.body, node.body[1:])
        if isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name) and isinstance(text, ast.Expr)
    ]
    return ["\n".join(keys) + "\n"] if keys else []


def is_public(node: ast.stmt) -> bool:
    return isinstance(node, ast.FunctionDef) and (not node.name.startswith("_") or node.name == "__len__")


def entry(node: ast.FunctionDef, owner: str) -> str:
    """Write a function, method or property."""
    is_property = any(isinstance(part, ast.Name) and part.id == "property" for part in node.decorator_list)
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    arguments = "" if is_property else f"({ast.unparse(node.args)})".replace("(self, ", "(").replace("(self)", "()")
    name = f"{owner}.{node.name}" if owner else node.name
    level = "###" if owner else "##"
    return f"{level} {name}\n\n```python\n{node.name}{arguments}{returns}\n```\n\n{doc(node)}"


def doc(node: ast.ClassDef | ast.FunctionDef) -> str:
    """Write a docstring; its sections in numpy's form become code blocks, whose columns they keep."""
    text = ast.get_docstring(node) or runtime_doc(node.name)
    head, *sections = text.split("\n\n")
    blocks = [head.replace("\n", " ")]
    for section in sections:
        blocks.append(f"```text\n{section}\n```" if "----" in section or section.startswith("    ") else section)
    return "\n\n".join(blocks) + "\n"


def runtime_doc(name: str) -> str:
    """Return the docstring that the compiled module has, where the stub has none."""
    import mesocrete

    for owner in (mesocrete, mesocrete.gjk, *(getattr(mesocrete, n) for n in mesocrete.__all__)):
        found = getattr(owner, name, None)
        if found is not None and getattr(found, "__doc__", None):
            import inspect

            return inspect.cleandoc(found.__doc__)
    return ""


def repository_links(pages: Path) -> None:
    """Point links to files beside docs/, which the site does not have, at their names."""
    import re

    for path in pages.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        plain = re.sub(r"\[([^\]]*)\]\((?:\.\./)+(?!docs/|[a-z_]+\.md|studies)([^)#]*)\)", r"\1 (`\2`)", text)
        if plain != text:
            path.write_text(plain, encoding="utf-8")


if __name__ == "__main__":
    main()
