"""A cylinder of scanned stones

A core of concrete with stones as they were scanned, dents included: packed, proved apart, meshed with a layer of ITZ. The
scan comes from NIST's public VCCTL, as spherical harmonics up to degree 8. A folder of such files gives more shapes.
[Grains with dents](../packing.md#grains-with-dents) has the options.
"""
from pathlib import Path

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

packing = mc.pack({
    "specimen": {"kind": "cylinder", "diameter_mm": 40, "height_mm": 60},
    "grading": {"d_min_mm": 6, "d_max_mm": 14, "size": "sieve"},
    "shape": {"kind": "harmonics", "path": "stone.dat", "triangles": 320},
    "itz": {"thickness_mm": [0.3, 0.3]},
    "placement": {"min_gap_mm": 0.3},
    "fraction": 0.45,
}, seed=1)
print(f"{len(packing)} stones, {100 * packing.fraction:.1f} % of the cylinder; check finds: {packing.check()['findings']}")

# The fitted lattice follows the stones and the mantle. Its elements have phases: mortar, aggregate, ITZ.
mesh = packing.mesh(method="lattice", element_size=2.0, itz="solid")
volumes = mesh.volumes()
print({phase: round(volume) for phase, volume in volumes.items()}, "mm3;", len(mesh.cells), "tetrahedra")

# Everything behind the cylinder's axis, coloured by phase.
grid = mesh.to_pyvista()
half = grid.extract_cells(grid.cell_centers().points[:, 1] > grid.center[1])
stones = np.asarray(packing.plot(screenshot=True, window_size=(700, 900)))[135:790, 60:640]
look = {"cmap": ["#d9d2c5", "#c8553d", "#7b6b58"], "lighting": False, "show_edges": True, "edge_color": "#a39c90", "line_width": 0.2}
view = {"cpos": "xz", "zoom": 1.3, "off_screen": True, "screenshot": True, "return_img": True, "window_size": (560, 640)}
cut = half.plot(scalars="phase", show_scalar_bar=False, show_axes=False, **look, **view)
figure, axes = plt.subplots(1, 2, figsize=(9, 5.7))
axes[0].imshow(stones)
axes[1].imshow(cut)
for picture, title in zip(axes, ["stones in the cylinder", "mesh behind the axis, with the ITZ"]):
    picture.set_title(title)
    picture.axis("off")
figure.tight_layout()
figure.savefig("picture.png", dpi=110)
