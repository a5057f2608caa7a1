"""Pages of the reference: each names objects of the package, which mkdocstrings reads from the stub and the modules."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "crates" / "meso-py" / "python" / "mesocrete"

# Pages by file name: the title, one sentence, the public names. Names that no page lists get a page of their own.
PAGES = {
    "pack": ("Pack and load", "Functions that make or read a packing.", ["pack", "load", "recipes"]),
    "packing": ("Packings", "`pack` and `load` return a packing.", ["Packing"]),
    "spec": ("Specs", "A spec determines a packing.", ["Spec", "Specimen", "Grading", "Materials"]),
    "mesh": ("Meshes", "`Packing.mesh` makes a mesh.", ["Mesh"]),
    "response": ("Tests", "`Mesh.solve` returns a response.", ["Response", "Frame", "Test"]),
    "bodies": ("Aggregates and polyhedra", "Bodies of a packing.", ["Aggregate", "Aggregates", "Polyhedron", "convex_hull"]),
    "study": ("Studies", "Many cases in one call.", ["study", "Study", "fit", "Fit", "mean_curves", "Curves"]),
    "dataset": ("Data sets", "Many volumes in one call.", ["dataset", "Dataset", "scan"]),
}
# Dicts, by the module that defines them.
OPTIONS = "Every option is a key of a dict. Pass them to the function that takes them, or write them in a `SPEC.toml`."
RESULTS = "The package returns these dicts."


def names(module: str) -> list[str]:
    """List the public names of a module: its `__all__`, or its classes."""
    body = ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8")).body
    for node in body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "__all__":
            return list(ast.literal_eval(node.value))
    classes = [node for node in body if isinstance(node, ast.ClassDef | ast.Assign)]
    found = [node.name if isinstance(node, ast.ClassDef) else ast.unparse(node.targets[0]) for node in classes]
    return [name for name in found if not name.startswith("_")]


def pages() -> dict[str, tuple[str, str, list[str]]]:
    """Return all pages by file name: title, sentence, and the full names of the objects on the page."""
    listed = {name for _, _, objects in PAGES.values() for name in objects}
    others = [name for name in names("__init__") if name not in {*listed, "gjk", "__version__"}]
    found = {page: (title, text, [f"mesocrete.{name}" for name in objects]) for page, (title, text, objects) in PAGES.items()}
    found |= {name.lower(): (name, "", [f"mesocrete.{name}"]) for name in others}
    found["gjk"] = ("Collision", "`mesocrete.gjk` decides whether convex bodies share a point.", [f"mesocrete.gjk.{name}" for name in names("gjk")])
    options = names("_types")
    of_runs = [name for name in options if name.startswith(("Mesh", "Deck", "Solve", "Statistics")) and "Specimen" not in name]
    of_specimens = [name for name in options if name.endswith("Specimen")]
    of_specs = [name for name in options if name not in {*of_runs, *of_specimens}]
    results = names("_results")
    of_packings = [name for name in results if results.index(name) < results.index("InterfaceDistance")]
    of_tests = [name for name in results if name not in of_packings]
    for page, title, text, module, objects in (
        ("options-spec", "Options of a spec", OPTIONS, "_types", of_specs),
        ("options-specimens", "Options of specimens", OPTIONS, "_types", of_specimens),
        ("options", "Options of meshes, decks and tests", OPTIONS, "_types", of_runs),
        ("results", "Results of packings", RESULTS, "_results", of_packings),
        ("results-tests", "Results of meshes and tests", RESULTS, "_results", of_tests),
    ):
        found[page] = (title, text, [f"mesocrete.{module}.{name}" for name in objects])
    return found


def write(folder: Path) -> list[tuple[str, str]]:
    """Write all pages and their index to a folder; return title and file of each."""
    folder.mkdir()
    index = ["# Reference\n", "Names of `import mesocrete as mc`. Lengths are in mm, stresses in MPa, fractions from 0 to 1.\n"]
    index += ["| page | names |\n|---|---|"]
    for page, (title, text, objects) in pages().items():
        body = "\n".join(directive(name) for name in objects)
        (folder / f"{page}.md").write_text(f"# {title}\n\n{text}\n\n{body}", encoding="utf-8")
        links = ", ".join(link(page, name) for name in objects)
        index.append(f"| [{title}]({page}.md) | {links} |")
    (folder / "index.md").write_text("\n".join(index) + "\n", encoding="utf-8")
    return [(title, f"reference/{page}.md") for page, (title, _, _) in pages().items()]


def link(page: str, name: str) -> str:
    """Return a link to an object on its page."""
    short = name.rpartition(".")[2]
    return f"[{short}]({page}.md#{anchor(name)})" if is_dict(name) else f"[{short}][{name}]"


def is_dict(name: str) -> bool:
    """Tell whether an object is the type of a dict, whose keys fit a table."""
    return name.startswith(("mesocrete._types.", "mesocrete._results."))


def anchor(name: str) -> str:
    """Return the anchor of a dict's heading."""
    return name.rpartition(".")[2].lower()


def directive(name: str) -> str:
    """Return the text of an object: for the type of a dict a table, else the line that mkdocstrings replaces."""
    return keys(name) if is_dict(name) else f"::: {name}\n"


def keys(name: str) -> str:
    """Write the type of a dict: its meaning, and its keys as a table."""
    _, module, short = name.split(".")
    body = ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8")).body
    for node, after in zip(body, [*body[1:], None]):
        if isinstance(node, ast.ClassDef) and node.name == short:
            return f"## {short} {{ #{anchor(name)} }}\n\n{ast.get_docstring(node) or ''}\n\n{table(class_rows(node))}"
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == short:
            text = ast.literal_eval(after.value) if isinstance(after, ast.Expr) else ""
            return f"## {short} {{ #{anchor(name)} }}\n\n{text}\n\n{assigned(node.value)}"
    raise LookupError(name)


def class_rows(node: ast.ClassDef) -> list[tuple[str, str, str]]:
    """Return key, type and meaning of every key of a dict's type."""
    return [
        (field.target.id, ast.unparse(field.annotation), " ".join(ast.literal_eval(text.value).split()))
        for field, text in zip(node.body, node.body[1:])
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(text, ast.Expr)
    ]


def assigned(value: ast.expr) -> str:
    """Write a type that is an expression: a dict with its keys, or one of several types."""
    if isinstance(value, ast.Call) and len(value.args) == 2 and isinstance(value.args[1], ast.Dict):
        pairs = zip(value.args[1].keys, value.args[1].values)
        return table([(ast.literal_eval(key), ast.unparse(kind), "") for key, kind in pairs if key])
    return f"`{ast.unparse(value)}`\n"


def table(rows: list[tuple[str, str, str]]) -> str:
    """Write rows of keys."""
    lines = [f"| `{key}` | `{kind.replace('|', chr(92) + '|')}` | {text.replace('|', chr(92) + '|')} |" for key, kind, text in rows]
    return "\n".join(["| key | type | meaning |", "|---|---|---|", *lines]) + "\n"
