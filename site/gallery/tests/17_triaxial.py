"""A confined cylinder

Pressure grows on all sides, and then plates press along z: the specimen becomes stronger, and friction
carries it beyond its peak.
[Tests](../tests.md) compares a cylinder of mortar with its law at one point within 2 %, and an elastic one with CalculiX.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cylinder(36, 36), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
response = mesh.solve(test=mc.Test.triaxial(5.0, friction=0.005), law="meso", frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "softened")})
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
