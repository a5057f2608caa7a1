"""The public surface of the core and of collision below it: how many items its documentation lists, counted from the sources.

An item is what rustdoc lists on its page of all items: a struct, enum, trait, function, constant or type. It counts where
`lib.rs` reaches it through public modules and `pub use`, and nothing on the way is `#[doc(hidden)]`. Methods and fields
belong to their types and do not count; modules do not either.
"""

import re
from functools import cache

from test_imports import ROOT, Module, leaves, modules

# About one screen of names for each of collision, packing, meshing and images.
MOST_ITEMS = 120
# Hidden items: those that the other crates of the workspace share - 29 of collision's, for the core - and what tests and
# benches look into.
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
    """The items of a crate that its users can name."""

    def __init__(self, crate: str) -> None:
        """Read the crate's files and follow what `lib.rs` publishes."""
        self.known = modules(crate)
        self.texts = {}
        for module, path in self.known.items():
            text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
            self.texts[module] = re.split(r"#\[cfg\((?:all\()?(?:test|doctest)[^\]]*\]\s*(?:mod|#)", text)[0]
        self.listed: set[tuple[Module, str]] = set()
        self.hidden: set[tuple[Module, str]] = set()
        self.visit((), hidden=False)
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
        """Take up what `pub use` names."""
        pattern = rf"(?P<attributes>(?:^#\[[^\n]*\]\n)*)^{indent}pub use\s+(?P<tree>[^;]+);"
        for found in re.finditer(pattern, text, re.MULTILINE):
            tree = re.sub(r"\s+", "", re.sub(r"\s+as\s+\w+", "", found["tree"]))
            for path in filter(self.is_own, leaves(tree)):
                self.add(*self.resolve(module, path), hidden=hidden or "doc(hidden)" in found["attributes"])

    @staticmethod
    def is_own(path: str) -> bool:
        """Whether a path names an item of the crate; those of another one count there."""
        return not path.endswith("::") and not path.startswith("meso_")

    def resolve(self, module: Module, path: str) -> tuple[Module, str]:
        """Find the file that defines a path, through re-exports."""
        *parts, name = path.split("::")
        at = list(module)
        for part in parts:
            if part == "super":
                at.pop()
            elif part == "crate":
                at = []
            elif part != "self":
                at.append(part)
        text = self.texts[tuple(at)]
        if re.search(rf"\b(?:{KINDS})\s+{name}\b", outer(text)):
            return tuple(at), name
        for tree in re.findall(r"(?<!\w)use\s+([^;]+);", text):
            for leaf in leaves(re.sub(r"\s+", "", re.sub(r"\s+as\s+\w+", "", tree))):
                if leaf.split("::")[-1] == name:
                    return self.resolve(tuple(at), leaf)
        raise AssertionError(f"{'::'.join(at)} has no {name}")

    def add(self, module: Module, name: str, *, hidden: bool) -> None:
        """Count an item once, as listed where any way to it is."""
        (self.hidden if hidden else self.listed).add((module, name))


def names(items: set[tuple[Module, str]]) -> list[str]:
    """The items' paths, in order."""
    return sorted("::".join((*module, name)) for module, name in items)


def test_the_core_shows_its_users_about_120_items() -> None:
    """A surface of a few screens, and little that is public but hidden."""
    surfaces = [Surface("meso-collision"), Surface("meso-core")]
    listed = [name for surface in surfaces for name in names(surface.listed)]
    hidden = [name for surface in surfaces for name in names(surface.hidden)]
    assert "model::pack" in listed
    assert "gjk::points::intersects" in listed
    assert "simd::isa" in hidden
    assert len(listed) <= MOST_ITEMS, f"{len(listed)} items are listed:\n" + "\n".join(listed)
    assert len(hidden) <= MOST_HIDDEN, f"{len(hidden)} items are hidden:\n" + "\n".join(hidden)


def test_the_crate_opens_with_the_example_of_the_readme() -> None:
    """Who meets the crate before the README reads the same lines."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```rust\n(.*?)```", readme, re.DOTALL)[1]
    docs = re.findall(r"^//! ?(.*\n)", (ROOT / "crates/meso-core/src/lib.rs").read_text(encoding="utf-8"), re.MULTILINE)
    assert f"```\n{example}```\n" in "".join(docs)
