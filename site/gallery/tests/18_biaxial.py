"""Two pairs of plates

Plates press along z, and a servo gives the plates across x half of their stress.
[Tests](../tests.md) compares the ratio of both stresses, and the equibiaxial strength of mortar with its law, within 2 %.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(36), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
response = mesh.solve(test="biaxial", stress_ratio=0.5, friction=0.005, frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "kinetic_over_internal_to_half_peak")})
print(f"{response.result['seconds']['total']:.0f} s")

# The body at the end, its damage from white to red, beside the curve.
grid = response.to_pyvista()
grid.points += 10.0 * grid.point_data["displacement_mm"]
look: dict[str, Any] = {"cmap": "Reds", "lighting": False, "show_edges": True, "edge_color": "lightgray", "show_scalar_bar": False}
look |= {"clim": (0.0, 1.0)}
body = grid.plot(scalars="damage", **look, off_screen=True, return_img=True, screenshot="body.png")
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.imshow(body[1] if isinstance(body, tuple) else body)
left.axis("off")
response.plot(ax=right)
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
