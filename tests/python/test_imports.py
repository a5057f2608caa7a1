"""The crates' files import downwards alone: no circles, and none above the floors that ARCHITECTURE names.

`use` lines are read as text. A path counts for the deepest module that has a file of its own; a module and those inside it
are one family, and imports within a line of it count as none. Unit tests may import what they like.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CRATES = sorted(path.parent.name for path in (ROOT / "crates").glob("*/Cargo.toml"))

# `mesh::build` takes a whole `Model`.
UPWARDS = {("mesh::build", "model")}

Module = tuple[str, ...]


def modules(crate: str) -> dict[Module, Path]:
    """Find every module of a crate that has a file of its own."""
    src = ROOT / "crates" / crate / "src"
    found = {}
    for path in src.rglob("*.rs"):
        parts = path.relative_to(src).with_suffix("").parts
        found[parts[:-1] if parts[-1] in ("mod", "lib") else parts] = path
    return found


def code(path: Path) -> str:
    """Read a file without its comments and unit tests."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    return re.split(r"#\[cfg\((?:all\()?test[^\]]*\]\s*mod \w+ \{", text)[0]


def imported(text: str) -> Iterator[str]:
    """Yield every path that the `use` lines name, trees taken apart."""
    for use in re.findall(r"(?<!\w)use\s+([^;]+);", text):
        yield from leaves(re.sub(r"\s+", "", re.sub(r"\s+as\s+\w+", "", use)))


def leaves(tree: str) -> Iterator[str]:
    """Take a `use` tree apart."""
    head, brace, rest = tree.partition("{")
    if not brace:
        yield tree
        return
    depth, part = 0, ""
    for letter in rest[:-1] + ",":
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            yield from leaves(head + part)
            part = ""
        else:
            part += letter


def target(path: str, own: Module, known: dict[Module, Path]) -> Module | None:
    """Find the module with a file of its own that a path lies in; none for other crates."""
    parts = path.split("::")
    at = list(own)
    if parts[0] == "crate":
        at = []
    elif parts[0] not in ("self", "super") and (*own, parts[0]) not in known:
        return None
    for part in parts:
        if part == "super" and at:
            at.pop()
        elif part not in ("crate", "self"):
            if (*at, part) not in known:
                break
            at.append(part)
    return tuple(at)


def edges(crate: str) -> dict[Module, set[Module]]:
    """Map every module to those that it imports from, but for its own family."""
    known = modules(crate)
    found = {}
    for own, path in known.items():
        targets = {target(use, own, known) for use in imported(code(path))} - {None}
        found[own] = {to for to in targets if own[: len(to)] != to and to[: len(own)] != own}
    return found


def circles(graph: dict[Module, set[Module]]) -> list[set[str]]:
    """Find the groups of modules that reach each other."""

    def reached(start: Module) -> set[Module]:
        seen, waiting = set(), [start]
        while waiting:
            new = graph[waiting.pop()] - seen
            seen |= new
            waiting.extend(new)
        return seen

    reach = {module: reached(module) for module in graph}
    groups = {frozenset(b for b in reach[a] if a in reach[b]) for a in graph if a in reach[a]}
    return [{"::".join(module) for module in group} for group in groups]


@pytest.mark.parametrize("crate", CRATES)
def test_no_files_import_each_other_in_a_circle(crate: str) -> None:
    """A circle of files cannot be read from the bottom up."""
    assert edges(crate), "the crate has files"
    assert circles(edges(crate)) == []


def floors() -> dict[str, int]:
    """Read the table of floors: each top module's number."""
    found = {}
    for line in (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines():
        row = re.match(r"\|\s*(\d)\s*\|([^|]*)\|", line)
        if row:
            names = re.findall(r"`(\w+)(?:\.rs|/)?`", row.group(2))
            found |= dict.fromkeys(names, int(row.group(1)))
    return found


def test_no_file_of_the_core_imports_from_a_floor_above_its_own() -> None:
    """ARCHITECTURE's table holds, and names every top module; collision's floors lie below the core's."""
    floor = floors()
    graph = {own: targets for crate in ("meso-collision", "meso-core") for own, targets in edges(crate).items() if own}
    assert {own[0] for own in graph} - set(floor) == set(), "modules that the table leaves out"
    upwards = {
        ("::".join(own), to[0])
        for own, targets in graph.items()
        for to in targets
        if to and floor[to[0]] > floor[own[0]]
    }
    assert upwards == UPWARDS


def test_every_dependency_has_its_reason_in_the_table_and_every_reason_a_dependency() -> None:
    kept = set()
    for crate in CRATES:
        text = (ROOT / "crates" / crate / "Cargo.toml").read_text(encoding="utf-8")
        for section in re.split(r"^\[", text, flags=re.MULTILINE):
            if re.match(r"(target\..*\.)?dependencies\]", section):
                kept |= set(re.findall(r"^([\w-]+)(?:\.workspace)? *=", section, re.MULTILINE))
    rows = re.findall(r"^\| ([\w, -]+) \|.*\|.*\|$", (ROOT / "SECURITY.md").read_text(encoding="utf-8"), re.MULTILINE)
    named = {name for row in rows for name in row.split(", ")} - {"crate"}
    assert named == {name for name in kept if name not in CRATES}
