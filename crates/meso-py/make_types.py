#!/usr/bin/env python3
"""Writes `mesocrete/_types.py`, the types of all options, from the JSON Schemas that `mesocrete schema` prints.

python3 crates/meso-py/make_types.py [PATH_OF_THE_COMMAND]

The schemas come from the Rust types that read the options; a test compares the file with what this would write.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

TARGET = Path(__file__).parent / "python" / "mesocrete" / "_types.py"

# Each schema and the name of its dict; what stands in `Spec` are the sections of a SPEC.toml.
SCHEMAS = {
    "spec": "SpecOptions",
    "mesh": "MeshOptions",
    "deck": "DeckOptions",
    "solve": "SolveOptions",
    "effective": "EffectiveOptions",
    "fit": "FitOptions",
    "statistics": "StatisticsOptions",
}
# A test with its name.
NAMED = '''class NamedTest(SolveOptions, total=False):
    """A test and its name, as `Test` returns it."""

    test: {kinds}
    """The named test."""
'''
# Steps of a study: options of requests, and those of the study alone.
STEPS = '''class MeshStep(MeshOptions, DeckOptions, total=False):
    """A mesh and its deck in a study: keywords of `Packing.mesh` and `Mesh.write`, and the files of the mesh."""

    output: str | Sequence[str]
    """Names of the files in the folder of a case; required."""
    method: Literal["voxel", "lattice", "conforming"]
    """Method of meshing."""
    element_size: float | Literal["auto"]
    """Edge length of the elements, mm."""
    accept_phase_error: bool
    """Whether a phase may be more than 10 % off its exact volume."""
    strict: bool
    """Whether a phase that is more than 1 % off fails the case."""
    compress: bool
    """Whether the data of a .vtu are compressed."""


class SolveStep(NamedTest, MeshOptions, total=False):
    """A test in a study: keywords of `Mesh.solve` and `Packing.mesh`."""

    method: Literal["voxel", "lattice", "conforming"]
    """Method of meshing."""
    element_size: float | Literal["auto"]
    """Edge length of the elements, mm."""
    accept_phase_error: bool
    """Whether a phase may be more than 10 % off its exact volume."""
    materials: DeckMaterials
    """Material values."""
    brush: bool
    """Plates of brushes or teflon: a friction of 0.005."""
    device: str
    """What takes the steps: "cpu", "gpu", "cuda:N" or "opencl:N"."""


class EffectiveStep(EffectiveOptions, total=False):
    """Effective properties in a study: keywords of `Packing.effective`."""

    element_size: float
    """Edge length of the tetrahedra, mm."""
    voxel_size: float
    """Edge of a voxel, mm."""
'''
# Keywords that the functions spell out themselves.
OWN_KEYWORDS = {
    "MeshOptions": {"method", "element_size_mm"},
    "SolveOptions": {"kind"},
    "EffectiveOptions": {"element_size_mm", "voxel_size_mm"},
    "FitOptions": {"element_size_mm", "min_gap_mm", "time_limit_s"},
}

HEAD = '''"""Types of all options, for editors and type checkers.

Written by make_types.py from `mesocrete schema`; do not edit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from numpy.typing import NDArray
import numpy as np

_Numbers = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]
'''


class Types:
    """The Python text of the types of one schema after another."""

    def __init__(self) -> None:
        self.text: dict[str, str] = {}
        # Choices of a few names stand where they are used.
        self.choices: dict[str, str] = {}
        self.prefix = ""

    def name(self, key: str) -> str:
        """Return the name of a definition; those of a test and a deck are told apart from a mesh's."""
        return key if self.prefix in ("Spec", "Mesh") else f"{self.prefix}{key}"

    def add(self, name: str, schema: dict[str, Any]) -> None:
        """Add a schema and all its definitions."""
        self.prefix = name.removesuffix("Options")
        definitions = schema.get("$defs", {})
        # Twice, since a choice may be of other choices.
        for key, definition in [*definitions.items(), *definitions.items()]:
            text = "" if '"properties"' in json.dumps(definition) else self.type(definition, key)
            if text.startswith("Literal["):
                self.choices[self.name(key)] = text
        for key, definition in definitions.items():
            if self.name(key) not in self.choices:
                self.text[self.name(key)] = self.definition(self.name(key), definition)
        self.text[name] = self.table(name, schema)

    def definition(self, name: str, schema: dict[str, Any]) -> str:
        forms = schema.get("oneOf", [])
        if forms and all("properties" in form for form in forms):
            return self.union(name, forms)
        if "properties" in schema:
            return self.table(name, schema)
        return f"{name} = {self.type(schema, name)}\n"

    def union(self, name: str, forms: list[dict[str, Any]]) -> str:
        """Return tagged forms, each a dict of its own."""
        names, text = [], ""
        for form in forms:
            tag = next(prop["const"] for prop in form["properties"].values() if "const" in prop)
            file = "File" if "file" in form["properties"] else ""
            own = "".join(part.capitalize() for part in tag.split("-")) + file + name
            names.append(own)
            text += self.table(own, form) + "\n\n"
        return text + f"{name} = {' | '.join(names)}\n"

    def table(self, name: str, schema: dict[str, Any]) -> str:
        lines = [f"class {name}(TypedDict, total=False):", f'    """{describe(schema, name)}"""', ""]
        for key, prop in schema["properties"].items():
            if key in OWN_KEYWORDS.get(name, set()):
                continue
            lines += [f"    {key}: {self.type(prop, name + key)}", f'    """{describe(prop, key)}"""']
        return "\n".join(lines) + "\n"

    def type(self, schema: dict[str, Any], where: str) -> str:
        """Return the Python type of a schema."""
        if "$ref" in schema:
            name = self.name(schema["$ref"].rsplit("/", 1)[1])
            return self.choices.get(name, name)
        if "const" in schema:
            return f"Literal[{json.dumps(schema['const'])}]"
        if "enum" in schema:
            return f"Literal[{', '.join(map(json.dumps, schema['enum']))}]"
        for key in ("anyOf", "oneOf", "allOf"):
            if key in schema:
                return join([self.type(form, where) for form in schema[key]])
        kinds = schema.get("type", "object")
        kinds = kinds if isinstance(kinds, list) else [kinds]
        return join([self.plain(kind, schema, where) for kind in kinds])

    def plain(self, kind: str, schema: dict[str, Any], where: str) -> str:
        names = {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}
        if kind in names:
            return names[kind]
        if kind == "array":
            inner = self.type(schema["items"], where)
            return "_Numbers" if inner == "float" else f"Sequence[{inner}]"
        return "dict[str, object]"


def join(types: list[str]) -> str:
    """Return a union; literals become one."""
    # A word may stand in two of them.
    words = (word for text in types if text.startswith("Literal[") for word in text[8:-1].split(", "))
    literals = list(dict.fromkeys(words))
    others = [text for text in types if not text.startswith("Literal[")]
    return " | ".join(dict.fromkeys([*([f"Literal[{', '.join(literals)}]"] if literals else []), *others]))


def describe(schema: dict[str, Any], name: str) -> str:
    """Return a schema's description on one line, links of Rust's documentation taken out."""
    form = f"Name of this form: '{schema['const']}'." if "const" in schema else f"Options: {name}."
    text = schema.get("description", form)
    text = re.sub(r"\[(`[^`]*`)\](\([^)]*\))?", r"\1", text)
    return " ".join(text.replace("::", ".").replace('"', "'").split())


def types(command: str) -> str:
    """Return the whole file."""
    found = Types()
    for of, name in SCHEMAS.items():
        printed = subprocess.run([command, "schema", of], capture_output=True, text=True, check=True).stdout
        found.add(name, json.loads(printed))
    found.text["NamedTest"] = NAMED.format(kinds=found.choices["SolveTestKind"])
    found.text["steps"] = STEPS
    return HEAD + "\n\n" + "\n\n".join(found.text.values())


if __name__ == "__main__":
    TARGET.write_text(types(sys.argv[1] if len(sys.argv) > 1 else "mesocrete"), encoding="utf-8")
