"""Tension

Plates are glued on and pull along z, until one crack goes through the specimen.
[Tests](../tests.md) compares it with the engine's weak bands, whose energy is within 10 % of the fracture energy.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(36), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
response = mesh.solve(test="tension", frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "energy_beyond_peak_n_per_mm")})
print(f"{response.result['seconds']['total']:.0f} s")

# The body at the end, its cracks from white to red, beside the curve.
grid = response.to_pyvista()
grid.points += 100.0 * grid.point_data["displacement_mm"]
look: dict[str, Any] = {"cmap": "Reds", "lighting": False, "show_edges": True, "edge_color": "lightgray", "show_scalar_bar": False}
look |= {"clim": (0.0, 0.02)}
body = grid.plot(scalars="crack_opening_mm", **look, off_screen=True, return_img=True, screenshot="body.png")
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.imshow(body[1] if isinstance(body, tuple) else body)
left.axis("off")
response.plot(ax=right)
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
