"""Spheres, polyhedra and a scanned stone

Three shapes of one sieve curve and one fraction: how do strength, diffusivity and the densest packing differ? The stone comes
from NIST's public VCCTL, as spherical harmonics up to degree 8; a folder of such files is a folder of stones.
[Grains with dents](../packing.md#grains-with-dents) has the options. The specimens are too small to trust, have no ITZ, and
keep the page quick.
"""
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc

# A line for each degree n: real and imaginary parts of the coefficients of orders m = 0 to n.
STONE = """29.21 0
.47 0 -.31 -.02
-2.28 0 -.53 1.27 .51 -1.03
2.31 0 -.05 .78 -.28 1.03 1.34 -.35
-.73 0 -.16 .36 -.25 .74 .37 .07 -.08 .14
-.55 0 -.09 .50 -.02 -.39 0 -.24 .25 .26 -.04 -.25
.40 0 .16 -.06 -.10 0 -.17 -.12 -.02 .18 .21 .10 .11 0
-.42 0 -.21 -.07 -.04 .17 -.05 .01 -.23 0 -.06 .14 .26 -.06 -.11 .14
-.07 0 -.07 0 0 -.20 -.08 -.08 .05 .08 -.07 .09 -.13 .03 .08 -.02 0 -.06"""
pairs = [np.reshape(line.split(), (-1, 2)) for line in STONE.splitlines()]
rows = [f"{n} {m} {real} {imaginary}" for n, degree in enumerate(pairs) for m, (real, imaginary) in enumerate(degree)]
Path("stone.dat").write_text("\n".join(rows), encoding="utf-8")

shapes: dict[str, dict[str, Any]] = {"sphere": {"kind": "sphere"}, "polyhedron": {"kind": "polyhedron"}, "stone": {"kind": "harmonics", "path": "stone.dat", "triangles": 320}}
grading = {"d_min_mm": 6.0, "d_max_mm": 10.0, "size": "sieve"}
spec = {"grading": grading, "itz": {"thickness_mm": [0, 0]}, "fraction": 0.35}
cube = spec | {"specimen": mc.Specimen.cube(30), "placement": {"min_gap_mm": 1.0}}
periodic = spec | {"specimen": mc.Specimen.cube(30, periodic=True)}
crowded = spec | {"specimen": mc.Specimen.cube(40, periodic=True)}
seeds = (1, 2, 3)


def peak(shape: dict[str, Any], seed: int) -> float:
    """Return the compressive strength, MPa."""
    mesh = mc.pack(cube | {"shape": shape}, seed=seed).mesh(for_test=True, element_size=2.5)
    return float(mesh.solve(friction=0.1, strain=0.003, frames=0).result["peak_mpa"])


def diffusivity(shape: dict[str, Any], seed: int) -> float:
    """Return the diffusivity over that of the mortar, around impermeable grains, as a mean of three axes."""
    tensor = mc.pack(periodic | {"shape": shape}, seed=seed).effective()["tensor"]
    return float(np.trace(np.array(tensor, dtype=float)) / 3)


def densest(shape: dict[str, Any]) -> mc.Packing:
    """Return the densest packing of the whole sieve curve, in steps of 0.02."""
    packing = mc.pack(crowded | {"shape": shape}, fraction=0.5, seed=1)
    while True:
        denser = mc.pack(crowded | {"shape": shape}, fraction=packing.fraction + 0.02, seed=1)
        if denser.report()["stop_reason"] != "target-reached":
            return packing
        packing = denser


measured: dict[str, list[float]] = {"strength, MPa": [], "diffusivity over mortar's": [], "densest fraction": []}
scatter: dict[str, list[float]] = {name: [] for name in measured}
figure, axes = plt.subplots(2, 3, figsize=(10, 6.5))
for picture, (name, shape) in zip(axes[0], shapes.items()):
    limit = densest(shape)
    found = [[peak(shape, seed) for seed in seeds], [diffusivity(shape, seed) for seed in seeds], [limit.fraction]]
    for quantity, values in zip(measured, found):
        measured[quantity].append(float(np.mean(values)))
        scatter[quantity].append(float(np.std(values, ddof=1)) if len(values) > 1 else 0.0)
        print(f"{name:10} {quantity:26} {measured[quantity][-1]:.3f} +- {scatter[quantity][-1]:.3f}")
    picture.imshow(limit.plot(screenshot=True, window_size=(600, 600)))
    picture.set_title(f"{name}, densest")
    picture.axis("off")

for plot, quantity in zip(axes[1], measured):
    plot.errorbar(list(shapes), measured[quantity], scatter[quantity], fmt="o", capsize=4)
    plot.set(ylabel=quantity, xlim=(-0.5, 2.5))
figure.tight_layout()
figure.savefig("picture.png", dpi=110)
