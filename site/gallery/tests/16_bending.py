"""Bending of a notched beam

Two rollers carry a notched beam, and a third one presses its middle; the crack mouth controls the speed (EN 14651).
[Tests](../tests.md) compares the work over the ligament with the fracture energy, and the elastic beam with CalculiX.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.notched_prism(100, 18, 28, notch_width_mm=6, notch_depth_mm=7), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
response = mesh.solve(test="bending", control="crack-mouth", strain=0.0012, frames=4)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "kinetic_over_internal_to_half_peak")})
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
right.plot(response.curve["crack_mouth_mm"], response.curve["stress_mpa"])
right.set(xlabel="crack mouth, mm", ylabel="flexural stress, MPa")
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
