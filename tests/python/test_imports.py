"""The crates' files import downwards alone: no circles, and none above the floors that ARCHITECTURE names.

`use` lines and the paths within the code are read as text. A path counts for the deepest module that has a file of its own,
and a name that this module only re-exports for the module that it comes from.
A module and those inside it are one family, and imports within it do not count. Unit tests may import what they like.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CRATES = sorted(path.parent.name for path in (ROOT / "crates").glob("*/Cargo.toml"))

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


USE = re.compile(r"(?<!\w)use\s+([^;]+);")


def imported(text: str) -> Iterator[str]:
    """Yield every path that the `use` lines name, trees taken apart, and every path within the code."""
    for use in USE.findall(text):
        yield from leaves(re.sub(r"\s+", "", re.sub(r"\s+as\s+\w+", "", use)))
    yield from re.findall(r"(?<![\w:$])(?:crate|super|self)(?:::\w+)+", USE.sub("", text))


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


Exports = dict[Module, dict[str, str]]


def exports(known: dict[Module, Path]) -> Exports:
    """Map every module to the names that it re-exports, with the paths that they come from."""
    found: Exports = {}
    for own, path in known.items():
        trees = re.findall(r"(?<!\w)pub(?:\([^)]*\))?\s+use\s+([^;]+);", code(path))
        paths = [leaf for tree in trees for leaf in leaves(re.sub(r"\s+as\s+", "=", tree).translate(NO_SPACE))]
        found[own] = {re.split("::|=", path)[-1]: path.partition("=")[0] for path in paths}
    return found


NO_SPACE = str.maketrans("", "", " \n")


def target(path: str, own: Module, known: dict[Module, Path], exported: Exports) -> Module | None:
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
                origin = exported[tuple(at)].get(part) if tuple(at) != own else None
                return (origin and target(origin, tuple(at), known, exported)) or tuple(at)
            at.append(part)
    return tuple(at)


def edges(crate: str) -> dict[Module, set[Module]]:
    """Map every module to those that it imports from, but for its own family."""
    known = modules(crate)
    exported = exports(known)
    found = {}
    for own, path in known.items():
        targets = {target(use, own, known, exported) for use in imported(code(path))} - {None}
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


def families(crate: str) -> dict[Module, dict[Module, set[Module]]]:
    """Map every folder to its families, a module with all below it, and to those beside them that they import from."""
    known = modules(crate)
    found: dict[Module, dict[Module, set[Module]]] = {}
    for own, targets in edges(crate).items():
        for to in targets:
            shared = next(k for k, (a, b) in enumerate(zip(own, to, strict=False)) if a != b)
            graph = found.setdefault(own[:shared], {})
            graph.setdefault(to[: shared + 1], set())
            graph.setdefault(own[: shared + 1], set()).add(to[: shared + 1])
    assert all(folder in known for folder in found)
    return found


# Folders of collision whose files are in no circle, but whose families are: a body is its faces, its measures and its proofs.
WHOLE = {("meso-collision", ("gjk",)), ("meso-collision", ("geometry",))}


@pytest.mark.parametrize("crate", CRATES)
def test_no_families_import_each_other_in_a_circle(crate: str) -> None:
    """What lies below a module belongs to it: a circle through a folder is a circle, too."""
    met = {folder for folder, graph in families(crate).items() if circles(graph)}
    assert met == {folder for name, folder in WHOLE if name == crate}


def floors(crate: str) -> dict[Module, int]:
    """Read a crate's table of floors: the number of each module that it names, as `room/` or `room/file.rs`."""
    architecture = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    section = re.search(rf"^### `?{crate}`?$(.*?)(?=^##|\Z)", architecture, re.MULTILINE | re.DOTALL)
    found = {}
    for number, names in re.findall(r"^\|\s*(\d+)\s*\|([^|]*)\|", section[1] if section else "", re.MULTILINE):
        for name in re.findall(r"`([\w/]+)(?:\.rs)?`", names):
            found[tuple(name.strip("/").split("/"))] = int(number)
    return found


def floor_of(module: Module, floor: dict[Module, int]) -> int:
    """Find the floor of a module: that of the deepest room around it that the table names."""
    rooms = [module[:length] for length in range(len(module), 0, -1) if module[:length] in floor]
    assert rooms, f"ARCHITECTURE's table of floors has no row for {'::'.join(module)}"
    return floor[rooms[0]]


STOREYED = [crate for crate in CRATES if len([module for module in modules(crate) if len(module) == 1]) > 3]


@pytest.mark.parametrize("crate", STOREYED)
def test_no_file_imports_from_a_floor_above_its_own(crate: str) -> None:
    """The crate's table in ARCHITECTURE covers every module, and names no module that is not there."""
    floor = floors(crate)
    known = modules(crate)
    assert set(floor) - set(known) == set(), "rooms that the table names, and the crate has not"
    graph = {own: targets for own, targets in edges(crate).items() if own}
    upwards = {
        f"{'::'.join(own)} -> {'::'.join(to)}"
        for own, targets in graph.items()
        for to in targets
        if to and floor_of(to, floor) > floor_of(own, floor)
    }
    assert upwards == set()


def test_paths_within_the_code_count_as_imports() -> None:
    """The circle of a table and its format once passed, since one of its two imports was no `use` line."""
    assert list(imported("use crate::a::{b, c};\nfn f() { crate::parquet::write(super::d::E) }")) == [
        "crate::a::b",
        "crate::a::c",
        "crate::parquet::write",
        "super::d::E",
    ]


def test_a_name_counts_for_the_module_that_it_is_re_exported_from(tmp_path: Path) -> None:
    """The circle of a body and its hull once passed, since both names came from the room around them."""
    known = {(): tmp_path / "lib.rs", ("a",): tmp_path / "a.rs", ("a", "b"): tmp_path / "b.rs"}
    texts = ["mod a;\npub use a::Inner;\n", "mod b;\npub(crate) use b::{self as c, Deep as Inner, Own};\n", "struct Deep;\n"]
    for path, text in zip(known.values(), texts, strict=True):
        path.write_text(text, encoding="utf-8")
    exported = exports(known)
    assert target("crate::Inner", ("z",), known, exported) == ("a", "b")
    assert target("crate::a::Other", ("z",), known, exported) == ("a",)


# A crate may use crates of lower numbers only.
CRATE_FLOORS = {
    "meso-collision": 0,
    "meso-concrete": 1,
    "meso-place": 2,
    "meso-spec": 3,
    "meso-pack": 4,
    "meso-mesh": 2,
    "meso-trial": 3,
    "meso-view": 3,
    "meso-write": 5,
    "meso-files": 5,
    "meso-gmsh": 3,
    "meso-element": 4,
    "meso-solve": 5,
    "meso-effective": 4,
    "meso-core": 6,
    "meso-gpu": 6,
    "meso-ask": 7,
    "meso-study": 8,
    "meso-cli": 9,
    "meso-py": 10,
}


def test_crates_depend_on_crates_of_lower_floors_only() -> None:
    """Packing and meshing are siblings: neither knows the other."""
    assert set(CRATE_FLOORS) == set(CRATES)
    for crate in CRATES:
        text = (ROOT / "crates" / crate / "Cargo.toml").read_text(encoding="utf-8")
        section = re.search(r"^\[dependencies\]$(.*?)(?=^\[)", text, re.MULTILINE | re.DOTALL)[1]
        for other in re.findall(r"^(meso-\w+)", section, re.MULTILINE):
            assert CRATE_FLOORS[other] < CRATE_FLOORS[crate], f"{crate} depends on {other}"


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
