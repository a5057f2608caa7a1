#!/usr/bin/env python3
"""Count how the source is built: crates, folders, names, comments. Prints a table of each figure beside its bar.

    python3 tools/house.py            # the table
    python3 tools/house.py --show what   # and the places that count for a figure

Rust sources of crates/*/src are read as text, without their unit tests where a figure says so. tests/python/test_house.py
holds the bars.
"""

import argparse
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
CRATES = ROOT / "crates"
# Crates that others use as libraries.
FRONTS = {"meso-cli", "meso-py"}
TESTS = re.compile(r"#\[cfg\((?:all\()?test[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*mod \w+ \{")


class Figure(NamedTuple):
    """A count, the bar that it should meet, and the places that it counts."""

    name: str
    count: float
    bar: float
    places: list[str]


def sources(crate: str = "*") -> list[Path]:
    """List the Rust files of a crate, or of all."""
    return sorted(CRATES.glob(f"{crate}/src/**/*.rs"))


def text_of(path: Path) -> str:
    """Read a file."""
    return path.read_text(encoding="utf-8")


def is_test(path: Path) -> bool:
    """Whether a whole file holds unit tests."""
    return path.name == "tests.rs" or "tests" in path.parts[path.parts.index("src") :]


def tested(path: Path) -> str:
    """Read a file without its unit tests, which stand at its end."""
    return "" if is_test(path) else TESTS.split(text_of(path))[0]


def lines(crate: str) -> int:
    """Count the lines of a crate without its unit tests."""
    return sum(tested(path).count("\n") for path in sources(crate))


def crates() -> list[str]:
    """List the crates."""
    return sorted(path.parent.name for path in CRATES.glob("*/Cargo.toml"))


def at(path: Path, text: str, start: int) -> str:
    """Name a place in a file."""
    return f"{path.relative_to(ROOT)}:{text.count(chr(10), 0, start) + 1}"


def found(pattern: str, *, libraries: bool = False) -> list[str]:
    """List the places outside unit tests that match."""
    places = []
    for path in sources():
        if libraries and path.parts[path.parts.index("crates") + 1] in FRONTS:
            continue
        text = tested(path)
        places += [at(path, text, match.start()) for match in re.finditer(pattern, text, re.MULTILINE)]
    return places


def folders() -> Counter[str]:
    """Count the Rust files of each folder."""
    return Counter(str(path.parent.relative_to(ROOT)) for path in sources())


def names_used_twice() -> list[str]:
    """List the names that types of two files have."""
    homes = defaultdict(set)
    for path in sources():
        for match in re.finditer(r"^(?:pub(?:\([^)]*\))? )?(?:struct|enum|trait|union) (\w+)", tested(path), re.MULTILINE):
            homes[match[1]].add(str(path.relative_to(ROOT)))
    return [f"{name} {sorted(places)}" for name, places in sorted(homes.items()) if len(places) > 1]


def names_with_two_meanings() -> list[str]:
    """List the public type names that two places of the libraries define."""
    homes = defaultdict(set)
    for path in sources():
        crate = path.parts[path.parts.index("crates") + 1]
        if crate in FRONTS:
            continue
        for match in re.finditer(r"^pub (?:struct|enum|trait|type|union) (\w+)", tested(path), re.MULTILINE):
            homes[match[1]].add(str(path.relative_to(ROOT)))
    return [f"{name}: {', '.join(sorted(where))}" for name, where in sorted(homes.items()) if len(where) > 1]


def out_of_range() -> list[str]:
    """List the structs and variants with the fields of a value out of range."""
    pattern = r"\w+ \{(?=[^}]*\bkey\b)(?=[^}]*\bvalue\b)(?=[^}]*\baccepted\b)[^}]*:[^}]*\}"
    declared = []
    for path in sources():
        text = re.sub(r"//[^\n]*", "", tested(path))
        for match in re.finditer(pattern, text):
            if re.search(r"\bkey: (?:String|&'static str|Cow|Box)", match[0]):
                declared.append(at(path, text, match.start()))
    return declared


def with_variant(name: str) -> list[str]:
    """List the enums with a variant."""
    found = []
    for path in sources():
        text = re.sub(r"//[^\n]*", "", tested(path))
        for match in re.finditer(r"enum \w+[^{;]*\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}", text):
            if re.search(rf"^\s+{name}\b", match[0], re.MULTILINE):
                found.append(at(path, text, match.start()))
    return found


def with_variants(*names: str) -> list[str]:
    """List the enums that have all of these variants."""
    return [place for place in with_variant(names[0]) if all(place in with_variant(name) for name in names[1:])]


def typed_flags() -> list[str]:
    """List the lines outside help whose text spells a flag of the command: a giver spells it as it was typed."""
    flag = r"(?<![\w-])--(?!version|gpu-architecture|ratio|help|features)[a-z][a-z-]+\b(?!:)"
    # In a text that begins in this line, or goes on from the one before.
    lines = found(rf'^(?!\s*(?://|#\[arg)).*"[^"\n]*{flag}|^(?!\s*//)[^"\n]*{flag}[^"\n]*(?:\\$|"$)')
    return [place for place in lines if "examples.rs" not in place]


def refusals() -> list[str]:
    """List the functions of commands that refuse what a request should."""
    return [place for place in found(r"fn (?:validate\w*|check|accept)\b") if "meso-cli/src/commands/" in place]


def figures() -> list[Figure]:
    """Count all."""
    by_crate = {crate: lines(crate) for crate in crates()}
    largest = max(by_crate, key=by_crate.__getitem__)
    total = sum(by_crate.values())
    fullest = folders()
    doors = [place for place in found(r"^pub fn build\w*", libraries=True) if "meso-mesh/src/build.rs" in place]
    detections = {place.split("/")[1] for place in found(r"feature_detected")}
    narrow = sorted({place.split(":")[0] for place in found(r"\bnarrow_gaps\b")})
    two = names_with_two_meanings()
    return [
        Figure("largest crate, % of lines", round(100 * by_crate[largest] / total, 1), 20, [str(by_crate)]),
        Figure("files in one folder", max(fullest.values()), 16, [str(fullest.most_common(3))]),
        Figure("enums with a variant Smeared", len(with_variant("Smeared")), 1, with_variant("Smeared")),
        Figure("enums with Mortar, Itz and Aggregate", len(phases := with_variants("Mortar", "Itz", "Aggregate")), 1, phases),
        Figure("files settings.rs of the command", len(settings := [str(path) for path in sources("meso-cli") if path.name == "settings.rs"]), 0, settings),
        Figure("validate, check, accept in commands", len(refusals()), 0, refusals()),
        Figure("lines that spell a flag, outside help", len(typed_flags()), 3, typed_flags()),
        Figure("fn require(", len(found(r"fn require\(")), 1, found(r"fn require\(")),
        Figure("types of {key, value, accepted}", len(out_of_range()), 1, out_of_range()),
        Figure("crates that detect instructions", len(detections), 1, sorted(detections)),
        Figure("public type names with two meanings", len(two), 0, two),
        Figure("type names used twice, private ones, too", len(twice := names_used_twice()), 90, twice),
        Figure("doc(hidden) in libraries", len(hidden()), 5, hidden()),
        Figure("doors to mesh::build", len(doors), 1, doors),
        Figure("files that name narrow_gaps", len(narrow), 4, narrow),
        Figure("functions of gjk without an example", len(without_example()), 0, without_example()),
    ]


def hidden() -> list[str]:
    """List the items of libraries that are public, but not in the documentation."""
    return found(r"#\[doc\(hidden\)\]", libraries=True)


def without_example() -> list[str]:
    """List the public functions of gjk whose documentation has no example."""
    places = []
    for path in sources("meso-collision"):
        text = tested(path) if "gjk" in path.parts else ""
        for match in re.finditer(r"((?:^ *(?:///|#\[).*\n)*)^ *pub (?:const )?fn \w+", text, re.MULTILINE):
            if "```" not in match[1]:
                places.append(at(path, text, match.end()))
    return places


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--show", default="", help="print the places of figures whose name contains this")
    args = parser.parse_args()
    counted = figures()
    for figure in counted:
        print(f"{figure.name:42} {figure.count:>9} {figure.bar:>7}  {'' if figure.count <= figure.bar else 'above'}")
        if args.show and args.show in figure.name:
            print("", *figure.places, sep="\n    ")
    return int(any(figure.count > figure.bar for figure in counted))


if __name__ == "__main__":
    sys.exit(main())
