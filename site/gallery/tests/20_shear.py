"""Shear of a double-notched prism

Plates are glued to the upper side left of two notches and to the lower side right of them. They move past each other,
and shear the plane between the notches' tips (Reinhardt and Xu 2000). [Tests](../tests.md) compares the elastic specimen with
CalculiX.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.notched_prism(60, 18, 48, notch_width_mm=6, notch_depth_mm=12, upper_notch_depth_mm=12), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
response = mesh.solve(test="shear", law="meso", strain=0.004, frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "softened")})
print(f"{response.result['seconds']['total']:.0f} s")

# The body at the end, its cracks from white to red, beside the curve.
grid = response.to_pyvista()
grid.points += 20.0 * grid.point_data["displacement_mm"]
look: dict[str, Any] = {"cmap": "Reds", "lighting": False, "show_edges": True, "edge_color": "lightgray", "show_scalar_bar": False}
look |= {"cpos": "xz", "clim": (0.0, 0.05)}
body = grid.plot(scalars="crack_opening_mm", **look, off_screen=True, return_img=True, screenshot="body.png")
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.imshow(body[1] if isinstance(body, tuple) else body)
left.axis("off")
response.plot(ax=right)
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
