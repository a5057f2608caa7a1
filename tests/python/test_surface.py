"""The public surface: how many items the documentation of the facade and of collision lists, counted from the sources.

An item is what rustdoc lists on its page of all items: a struct, enum, trait, function, constant or type. It counts where
the facade's `lib.rs` reaches it through public modules and `pub use`, in whichever crate it stands, and nothing on the way is
`#[doc(hidden)]`. Methods and fields belong to their types and do not count; modules do not either.
"""

import re
from functools import cache

from test_imports import CRATES, ROOT, Module, leaves, modules

LIBRARIES = [crate for crate in CRATES if crate not in ("meso-cli", "meso-py")]

# Names that the facade's `lib.rs` itself re-exports: one screen.
MOST_NAMES = 30
# Items that users can reach through it, and those of collision: 171, and most of the 29 that collision shares with its siblings.
# Tests, materials of a concrete, stone and sieve tables brought 21; surfaces with dents and harmonics 5;
# label volumes, round bodies and the reduction of scans 12; grains from label volumes 14; heights over dents 2; bodies that a mesh takes 1;
# bodies of a file and their polygons, and the skin of cut bodies 3; what reductions cost, files under wrong names and numbers of bodies 4;
# a mortar's strength by its law, physical ranges, questions about labels and what an import lost 4; drilled cores 2; samples 1; supports in real time 3; sentences of a citation 2; fields of strengths 5, less pairs of many 1; forms of bodies 1.
MOST_ITEMS = 339
# Items of collision that its sibling crates share.
MOST_HIDDEN = 65

KINDS = r"fn|struct|enum|trait|const|static|type"
HEAD = r"^(?P<attributes>(?:#\[[^\n]*\]\s*)*)pub (?:const |unsafe )*"


@cache
def outer(text: str) -> str:
    """Blank what stands in braces, so that only a module's own items are left."""
    depth, kept = 0, []
    for letter in text:
        depth -= letter == "}"
        kept.append(letter if depth == 0 or letter == "\n" else " ")
        depth += letter == "{"
    return "".join(kept)


class Surface:
    """The items of a crate that its users can name, those of the crates that it re-exports included."""

    def __init__(self, crate: str) -> None:
        """Read the libraries' files and follow what the crate's `lib.rs` publishes. A module begins with its crate."""
        paths = {(name, *module): path for name in LIBRARIES for module, path in modules(name).items()}
        self.texts = {}
        for module, path in paths.items():
            text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
            self.texts[module] = re.split(r"#\[cfg\((?:all\()?(?:test|doctest)[^\]]*\]\s*(?:mod|#)", text)[0]
        self.listed: set[tuple[Module, str]] = set()
        self.hidden: set[tuple[Module, str]] = set()
        self.visit((crate,), hidden=False)
        self.hidden -= self.listed

    def visit(self, module: Module, *, hidden: bool) -> None:
        """Take up a public module: its items, its re-exports and the public modules in it."""
        text = self.texts[module]
        for found in re.finditer(HEAD + rf"(?:{KINDS})\s+(?P<name>\w+)", outer(text), re.MULTILINE):
            self.add(module, found["name"], hidden=hidden or "doc(hidden)" in found["attributes"])
        for found in re.finditer(HEAD + r"mod (?P<name>\w+)(?P<body>\s*\{.*?^\})?", text, re.MULTILINE | re.DOTALL):
            is_hidden = hidden or "doc(hidden)" in found["attributes"]
            if found["body"]:
                self.reexports(module, found["body"], indent=r"\s+", hidden=is_hidden)
            else:
                self.visit((*module, found["name"]), hidden=is_hidden)
        self.reexports(module, text, indent="", hidden=hidden)

    def reexports(self, module: Module, text: str, *, indent: str, hidden: bool) -> None:
        """Take up what `pub use` names: an item, a module, or a crate."""
        pattern = rf"(?P<attributes>(?:^#\[[^\n]*\]\n)*)^{indent}pub use\s+(?P<tree>[^;]+);"
        for found in re.finditer(pattern, text, re.MULTILINE):
            is_hidden = hidden or "doc(hidden)" in found["attributes"]
            for path in paths_of(found["tree"]):
                at, name = self.resolve(module, path)
                if name:
                    self.add(at, name, hidden=is_hidden)
                else:
                    self.visit(at, hidden=is_hidden)

    def resolve(self, module: Module, path: str) -> tuple[Module, str]:
        """Find the file that defines a path, through re-exports; without a name, the path is a module."""
        at, parts = list(module), path.split("::")
        for place, part in enumerate(parts):
            if part == "super":
                at.pop()
            elif part == "crate":
                at = at[:1]
            elif part.startswith("meso_") and place == 0:
                at = [part.replace("_", "-")]
            elif (*at, part) in self.texts:
                at.append(part)
            elif re.search(rf"^pub mod {part} \{{", self.texts[tuple(at)], re.MULTILINE):
                continue  # A module of re-exports within the file, which `defined` reads.
            elif part != "self":
                return self.defined(tuple(at), part)
        return tuple(at), ""

    def defined(self, module: Module, name: str) -> tuple[Module, str]:
        """Find the file that defines a name that a module has, itself or from elsewhere."""
        text = self.texts[module]
        if re.search(rf"\b(?:{KINDS})\s+{name}\b", outer(text)):
            return module, name
        for tree in re.findall(r"(?<!\w)use\s+([^;]+);", text):
            for leaf in paths_of(tree):
                if leaf.split("::")[-1] == name:
                    return self.resolve(module, leaf)
        raise AssertionError(f"{'::'.join(module)} has no {name}")

    def add(self, module: Module, name: str, *, hidden: bool) -> None:
        """Count an item once, as listed where any way to it is."""
        (self.hidden if hidden else self.listed).add((module, name))


def paths_of(tree: str) -> list[str]:
    """The paths that a `use` tree names."""
    plain = re.sub(r"\s+", "", re.sub(r"\s+as\s+\w+", "", tree))
    return [path for path in leaves(plain) if not path.endswith("::")]


def names(items: set[tuple[Module, str]]) -> list[str]:
    """The items' paths, in order."""
    return sorted("::".join((*module, name)) for module, name in items)


def test_the_facade_is_one_screen_of_names() -> None:
    """Who opens the documentation of meso-core sees modules and a few types."""
    text = re.sub(r"//[^\n]*", "", (ROOT / "crates/meso-core/src/lib.rs").read_text(encoding="utf-8"))
    shown = [path for tree in re.findall(r"^pub use\s+([^;]+);", text, re.MULTILINE) for path in paths_of(tree)]
    assert len(shown) <= MOST_NAMES, shown
    assert "meso_pack::pack" in shown


def test_users_of_the_facade_and_of_collision_see_a_bounded_number_of_items() -> None:
    """Items of the inner crates count where the facade reaches them."""
    facade, collision = Surface("meso-core"), Surface("meso-collision")
    listed, hidden = names(facade.listed | collision.listed), names(collision.hidden)
    assert "meso-pack::model::pack" in listed
    assert "meso-collision::gjk::ask::points::intersects" in listed
    assert len(listed) <= MOST_ITEMS, f"{len(listed)} items are listed:\n" + "\n".join(listed)
    assert len(hidden) <= MOST_HIDDEN, f"{len(hidden)} items are hidden:\n" + "\n".join(hidden)


def test_the_crate_opens_with_the_example_of_the_readme() -> None:
    """Who meets the crate before the README reads the same lines."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```rust\n(.*?)```", readme, re.DOTALL)[1]
    docs = re.findall(r"^//! ?(.*\n)", (ROOT / "crates/meso-core/src/lib.rs").read_text(encoding="utf-8"), re.MULTILINE)
    assert f"```\n{example}```\n" in "".join(docs)
