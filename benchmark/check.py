#!/usr/bin/env python3
"""Checks a packing of any program against a spec of the benchmark, and prints a row for results.csv.

python3 benchmark/check.py benchmark/specs/2-cube-50.toml BODIES.json

BODIES.json is {"bodies": [[[x, y, z], ...], ...]}: the corners of every grain, in mm, in a specimen that begins at the
origin; a cylinder stands upright, and its axis passes through the middle of its bounding box. Each grain is the convex
hull of its corners. Needs `mesocrete` for hulls and exact overlaps, and nothing else of it. The exit code is 0 where
every rule is kept.
"""

import csv
import itertools
import json
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

import mesocrete as mc

# Rules: the fraction may fall short by this, a class may be off by this share of its target, sizes have this rounding.
SHORT, CLASS_OFF, ROUNDING_MM = 0.002, 0.01, 1e-6
COLUMNS = ["spec", "fraction", "grains", "worst_class_percent", "overlapping_pairs", "outside", "wrong_size", "kept"]


def box(specimen: dict[str, Any]) -> np.ndarray:
    """Return the edges of the specimen's bounding box, mm."""
    if specimen["kind"] == "cylinder":
        return np.array([specimen["diameter_mm"], specimen["diameter_mm"], specimen["height_mm"]], float)
    return np.full(3, float(specimen["side_mm"]))


def volume(specimen: dict[str, Any]) -> float:
    """Return the specimen's volume, mm3."""
    share = np.pi / 4.0 if specimen["kind"] == "cylinder" else 1.0
    return float(share * box(specimen).prod())


def outside(specimen: dict[str, Any], bodies: list[np.ndarray]) -> int:
    """Count the grains that leave the specimen; none leaves a periodic one."""
    edges = box(specimen)
    if specimen.get("periodic"):
        return 0
    beyond = [bool((body < -ROUNDING_MM).any() or (body > edges + ROUNDING_MM).any()) for body in bodies]
    if specimen["kind"] == "cylinder":
        radius = specimen["diameter_mm"] / 2.0 + ROUNDING_MM
        beyond = [out or bool((np.hypot(*(body[:, :2] - edges[:2] / 2.0).T) > radius).any()) for out, body in zip(beyond, bodies)]
    return sum(beyond)


def with_images(specimen: dict[str, Any], bodies: list[np.ndarray]) -> list[np.ndarray]:
    """Return the grains and, in a periodic specimen, their images that reach into it."""
    if not specimen.get("periodic"):
        return bodies
    edges = box(specimen)
    # Each grain by the image whose middle lies in the specimen.
    bodies = [body - np.floor(body.mean(axis=0) / edges) * edges for body in bodies]
    shifts = [np.array(shift) * edges for shift in itertools.product((-1, 0, 1), repeat=3) if any(shift)]
    moved = [body + shift for body in bodies for shift in shifts]
    return bodies + [body for body in moved if (body.max(axis=0) >= 0.0).all() and (body.min(axis=0) <= edges).all()]


def sizes(bodies: list[np.ndarray]) -> np.ndarray:
    """Return the longest distance of two corners of every grain, mm."""
    return np.array([np.sqrt(((body[:, None] - body[None]) ** 2).sum(axis=2).max()) for body in bodies])


def classes(grading: dict[str, Any]) -> list[tuple[float, float, float]]:
    """Return limits and share of every class: Fuller's curve, normalised between its limits."""
    limits = grading["classes_mm"]
    passing = np.array(limits, float) ** grading["curve"]["exponent"]
    shares = np.diff(passing) / (passing[-1] - passing[0])
    return [(low, high, float(share)) for low, high, share in zip(limits, limits[1:], shares)]


def check(spec: dict[str, Any], bodies: list[np.ndarray]) -> dict[str, Any]:
    """Return the row of a packing."""
    specimen, grading = spec["specimen"], spec["grading"]
    volumes = np.array([mc.convex_hull(body).volume for body in bodies]) / volume(specimen)
    size = sizes(bodies)
    errors, counted = [], np.zeros(len(bodies), bool)
    for low, high, share in classes(grading):
        inside = (size >= low - ROUNDING_MM) & (size <= high + ROUNDING_MM) & ~counted
        counted |= inside
        errors.append(volumes[inside].sum() / (share * spec["fraction"]) - 1.0)
    worst = max(errors, key=abs)
    found = {
        "fraction": round(float(volumes.sum()), 5),
        "grains": len(bodies),
        "worst_class_percent": round(100.0 * float(worst), 2),
        "overlapping_pairs": len(mc.gjk.Bodies(with_images(specimen, bodies)).overlapping_pairs()),
        "outside": outside(specimen, bodies),
        "wrong_size": int((~counted).sum()),
    }
    kept = not (found["overlapping_pairs"] or found["outside"] or found["wrong_size"])
    reached = volumes.sum() >= spec["fraction"] - SHORT and abs(worst) <= CLASS_OFF
    return found | {"kept": "yes" if kept and reached else "no"}


def main() -> int:
    """Check one file and print its row."""
    spec_path, bodies_path = map(Path, sys.argv[1:])
    spec = tomllib.loads(spec_path.read_text(encoding="utf-8"))
    bodies = [np.array(body, float) for body in json.loads(bodies_path.read_text(encoding="utf-8"))["bodies"]]
    row = {"spec": spec_path.stem} | check(spec, bodies)
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerow(row)
    return 0 if row["kept"] == "yes" else 1


if __name__ == "__main__":
    sys.exit(main())
