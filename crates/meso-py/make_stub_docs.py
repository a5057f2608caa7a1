#!/usr/bin/env python3
"""Copies the docstrings of the compiled module into its stub, which is what editors show.

python3 crates/meso-py/make_stub_docs.py     (with the package installed)

The docstrings stand in the Rust sources; a test compares the stub with what this would write.
"""

import ast
import inspect
from pathlib import Path

STUB = Path(__file__).parent / "python" / "mesocrete" / "_mesocrete.pyi"


def documented(text: str) -> str:
    """Return the stub with the compiled module's docstrings in every public class, function, method and property."""
    from mesocrete import _mesocrete

    lines = text.splitlines()
    module = ast.parse(text).body
    edits = functions(module, _mesocrete, "    ")
    for node in module:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            edits += functions(node.body, getattr(_mesocrete, node.name, None), "        ")
    for first, last, new in sorted(edits, reverse=True):
        lines[first:last] = new
    return "\n".join(lines) + "\n"


def functions(nodes: list[ast.stmt], owner: object, indent: str) -> list[tuple[int, int, list[str]]]:
    """Return the edits of a module's or a class's public functions. Of overloads the first has the docstring."""
    edits: list[tuple[int, int, list[str]]] = []
    before = ""
    for node in nodes:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            if node.name != before:
                edits += edit(node, getattr(owner, node.name, None), indent)
            before = node.name if is_overload(node) else ""
    return edits


def is_overload(node: ast.FunctionDef) -> bool:
    return any(isinstance(part, ast.Name) and part.id == "overload" for part in node.decorator_list)


def edit(node: ast.FunctionDef, found: object, indent: str) -> list[tuple[int, int, list[str]]]:
    """Return the lines of a function's body to replace, and the docstring in their place."""
    docstring = inspect.cleandoc(getattr(found, "__doc__", None) or "")
    if not docstring:
        return []
    quoted = '"""' + docstring.replace("\\", "\\\\") + ('\n"""' if "\n" in docstring else '"""')
    body = [f"{indent}{line}".rstrip() for line in quoted.splitlines()]
    head, end = node.body[0], node.end_lineno or 0
    if head.lineno == end and is_dots(head):
        # `def f(...) -> T: ...` keeps its line without the dots.
        return [(end - 1, end, [line_without_dots(node), *body, ""])]
    return [(head.lineno - 1, end, body)]


def is_dots(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and node.value.value is Ellipsis


def line_without_dots(node: ast.FunctionDef) -> str:
    line = STUB.read_text(encoding="utf-8").splitlines()[(node.end_lineno or 1) - 1]
    return line.rsplit("...", 1)[0].rstrip()


if __name__ == "__main__":
    STUB.write_text(documented(STUB.read_text(encoding="utf-8")), encoding="utf-8")
