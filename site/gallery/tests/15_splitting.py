"""Splitting

Strips press a cylinder on its mantle (EN 12390-6): it splits in tension. Elements of half a strip give three rows of
nodes under it. [Tests](../tests.md) compares an elastic disc with its closed form within 1 %, and the strength with that in
tension.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cylinder(40, 20), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=2.0)
response = mesh.solve(test="splitting", law="meso", frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "softened")})
print(f"{response.result['seconds']['total']:.0f} s")

# The body at the end, its cracks from white to red, beside the curve.
grid = response.to_pyvista()
grid.points += 10.0 * grid.point_data["displacement_mm"]
look: dict[str, Any] = {"cmap": "Reds", "lighting": False, "show_edges": True, "edge_color": "lightgray", "show_scalar_bar": False}
look |= {"cpos": "xy", "clim": (0.0, 0.02)}
body = grid.plot(scalars="crack_opening_mm", **look, off_screen=True, return_img=True, screenshot="body.png")
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.imshow(body[1] if isinstance(body, tuple) else body)
left.axis("off")
response.plot(ax=right)
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
