#!/usr/bin/env python3
"""Writes `mesocrete/_results.py`, the types of all dicts that the package returns, from the Rust structs that they show.

python3 crates/meso-py/make_results.py

A test compares the file with what this would write, and the dicts with the types.
"""

import re
from pathlib import Path

CRATES = Path(__file__).parents[1]
TARGET = Path(__file__).parent / "python" / "mesocrete" / "_results.py"

# Where the structs stand, in the order in which they are written; a dict's own keys follow in `EXTENDED`.
SOURCES = {
    "meso-concrete/src/aggregate/library.rs": ["Reduction"],
    "meso-place/src/report.rs": [
        *["SpecimenReport", "ClassReport", "PhaseReport", "OwnPhaseReport", "ShellReport", "Work", "Seconds", "ReducedGrain"],
        *["CoreReport", "LabelReport", "Report"],
    ],
    "meso-pack/src/statistics/distribution.rs": ["Distribution"],
    "meso-pack/src/statistics/shape.rs": ["Zingg", "Shapes", "Orientation"],
    "meso-pack/src/statistics/wall.rs": ["WallEffect"],
    "meso-pack/src/statistics/correlation.rs": ["Correlation"],
    "meso-pack/src/statistics/phases.rs": ["PhaseFigures"],
    "meso-pack/src/statistics/budget.rs": ["Sampled"],
    "meso-pack/src/statistics/mod.rs": ["Statistics"],
    "meso-mesh/src/figures/interface_distance.rs": ["InterfaceDistance"],
    "meso-mesh/src/figures/phase_volumes.rs": ["PhaseVolumes"],
    "meso-mesh/src/figures/quality.rs": ["QualityReport"],
    "meso-mesh/src/figures/mass_scaling.rs": ["PhaseScaling", "MassScaling"],
    "meso-pack/src/check/mod.rs": ["Check"],
    "meso-effective/src/bounds.rs": ["PropertyBounds"],
    "meso-effective/src/resolution.rs": ["Resolution"],
    "meso-effective/src/effective.rs": ["At", "PhaseShare", "Effective"],
    "meso-effective/src/elastic/task.rs": ["ElasticShare", "ElasticBounds", "Isotropic", "Stiffness"],
    "meso-effective/src/tetrahedra/unloading.rs": ["Unloading"],
    "meso-solve/src/march/curve.rs": ["Figures"],
    "meso-solve/src/march/beyond_peak.rs": ["BeyondPeak"],
    "meso-solve/src/march/lateral.rs": ["Lateral"],
    "meso-trial/src/trial/setup.rs": ["Setup"],
    "meso-mesh/src/materials/scatter.rs": ["Scatter"],
    "meso-solve/src/march/response.rs": ["Energies", "PhaseResult", "Summary"],
}
# Structs whose dict differs from them: its own name, keys that it lacks, keys that it adds.
CHANGED = {
    "Report": ("Report", {"seconds"}, []),
    "Work": ("Work", set(), []),
    "ReducedGrain": ("ReducedGrain", {"reduction"}, []),
    "Check": ("CheckResult", set(), [("sound", "bool", "True where nothing was found.")]),
    "Figures": ("CurveFigures", set(), []),
    "Effective": ("Effective", {"resolution", "at"}, []),
    "Stiffness": ("Stiffness", {"resolution"}, []),
    "Unloading": ("Unloading", {"resolution", "at"}, []),
    # What `result.json` has of the packing and the run.
    "Summary": (
        "TestResult",
        {"setup", "figures", "beyond_peak", "lateral"},
        [
            ("version", "str", "Of mesocrete."),
            ("seed", "int", "Of the packing."),
            ("fraction", "float", "Of the packing."),
            ("mesh", "dict[str, object]", "The options of the mesh."),
            ("frames", "list[dict[str, str | int | float]]", "File, number, strain and stress of every frame."),
            ("seconds", "dict[str, float]", "Wall times by part, s."),
        ],
    ),
}
# A dict that has the keys of another, too.
BASES = {
    "ReducedGrain": "Reduction",
    "Summary": "Setup, CurveFigures, BeyondPeak, Lateral",
    "Effective": "Resolution, At",
    "Stiffness": "Resolution",
    "Unloading": "Resolution, At",
}
PLAIN = {
    "f64": "float", "usize": "int", "u64": "int", "u32": "int", "u16": "int", "u8": "int", "i64": "int", "bool": "bool",
    "String": "str", "&'static str": "str",
    # Names of a choice, and findings, which are a kind and its own keys.
    "StopReason": "str", "Kind": "str", "TestKind": "str", "LawName": "str", "Control": "str", "Smoothing": "str",
    "StrengthDistribution": "str", "Covariance": "str", "ScatteredPhase": "str",
    "Ended": "str | dict[str, str]",
    # Rows of a tensor, None where not asked for.
    "Property": "str", "FluxTensor": "list[list[float | None]]", "StiffnessTensor": "list[list[float]]",
    # Tables of a TEST.toml.
    "Expansion": "dict[str, float | None]", "Turn": "dict[str, float | str]",
    "SupportSpec": "dict[str, object]", "Gauge": "dict[str, object]",
    "BTreeMap<String, f64>": "dict[str, float]",
    "Finding": "dict[str, str | int | float]",
}  # fmt: skip

HEAD = '''"""Types of all dicts that the package returns, for editors and type checkers.

Written by make_results.py from the Rust structs; do not edit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import NotRequired

# `class` is no name of Python's: the table and a few more have their keys as texts.
Table = TypedDict(
    "Table",
    {
        "id": NDArray[np.int64],
        "class": NDArray[np.int64],
        "phase": NDArray[np.str_],
        "size_mm": NDArray[np.float64],
        "sieve_size_mm": NDArray[np.float64],
        "volume_mm3": NDArray[np.float64],
        "area_mm2": NDArray[np.float64],
        "sphericity": NDArray[np.float64],
        "centroid_x_mm": NDArray[np.float64],
        "centroid_y_mm": NDArray[np.float64],
        "centroid_z_mm": NDArray[np.float64],
        "itz_thickness_mm": NDArray[np.float64],
        "vertices": NDArray[np.int64],
        "faces": NDArray[np.int64],
    },
)
"""Every aggregate, void and fibre as a row."""
'''


Field = tuple[str, str, str, bool]


def struct(text: str, name: str) -> tuple[str, list[Field]]:
    """Return a struct's documentation and its fields: name, Rust type, documentation, and whether it may be left out."""
    pattern = rf"((?:///[^\n]*\n)+)(?:#\[[^\n]*\n)*pub struct {name} \{{\n(.*?)\n\}}"
    body = re.search(pattern, text, re.S)
    if body is None:
        message = f"there is no struct {name}"
        raise ValueError(message)
    fields, docs, optional, renamed, hidden = [], [], False, None, False
    for line in map(str.strip, body[2].splitlines()):
        if line.startswith("///"):
            docs.append(line[3:].strip())
        elif line.startswith("#[serde"):
            optional |= "skip_serializing_if" in line
            hidden |= line == "#[serde(skip)]"
            renamed = (re.search(r'rename = "(\w+)"', line) or [None, renamed])[1]
        elif field := re.match(r"pub (\w+): (.*),$", line):
            if not hidden:
                fields.append((renamed or field[1], field[2], " ".join(docs), optional))
            docs, optional, renamed, hidden = [], False, None, False
    return " ".join(line[3:].strip() for line in body[1].splitlines()), fields


def python(rust: str) -> str:
    """Return the Python type of a Rust type as JSON has it."""
    if rust in PLAIN:
        return PLAIN[rust]
    if match := re.fullmatch(r"Option<(.*)>", rust):
        return f"{python(match[1])} | None"
    if match := re.fullmatch(r"Vec<(.*)>|\[(.*); \w+\]", rust):
        return f"list[{python(match[1] or match[2])}]"
    if rust == "(f64, usize)":
        return "list[float]"
    return CHANGED.get(rust, (rust,))[0]


def documented(text: str) -> str:
    """Return a struct's documentation on one line, links of Rust's documentation taken out."""
    return re.sub(r"\[(`[^`]*`)\](\([^)]*\))?", r"\1", text).replace('"', "'")


def table(name: str, doc: str, fields: list[Field]) -> str:
    own, without, more = CHANGED.get(name, (name, set(), []))
    lines = [f"class {own}({BASES.get(name, 'TypedDict')}):", f'    """{documented(doc)}"""', ""]
    for key, kind, doc in more:
        lines += [f"    {key}: {kind}", f'    """{doc}"""']
    for key, rust, doc, optional in fields:
        if key in without:
            continue
        kind = f"NotRequired[{python(rust)}]" if optional else python(rust)
        lines += [f"    {key}: {kind}", f'    """{documented(doc)}"""']
    return "\n".join(lines) + "\n"


def results() -> str:
    """Return the whole file."""
    tables = []
    for source, names in SOURCES.items():
        text = (CRATES / source).read_text(encoding="utf-8")
        tables += [table(name, *struct(text, name)) for name in names]
    work = '\n\nclass WorkDone(Work):\n    """The work and its wall times."""\n\n    seconds: Seconds\n    """By stage, s."""\n'
    return HEAD + "\n\n" + "\n\n".join(tables) + work


if __name__ == "__main__":
    TARGET.write_text(results(), encoding="utf-8")
