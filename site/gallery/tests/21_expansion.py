"""Aggregates that swell

Aggregates swell by 1 per mille, as in an alkali-silica reaction, between plates at rest; then the cracked specimen is
crushed. [Tests](../tests.md) compares free bodies, layers and a sphere in a shell with their closed forms.
"""
from typing import Any

import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(36), "grading": mc.Grading.fuller(8, 14), "fraction": 0.25, "placement": {"min_gap_mm": 1.5}}
packing = mc.pack(spec, seed=1)
mesh = packing.mesh(for_test=True, element_size=3.0)
swollen = mesh.solve(test="compression", expansion={"aggregate": 1e-3}, friction=0.1, frames=4)
response = swollen
sound = mesh.solve(test="compression", friction=0.1)
print({"sound": sound.result["peak_mpa"], "swollen": swollen.result["peak_mpa"]})
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
for name, each in [("sound", sound), ("swollen", swollen)]:
    right.plot(each.curve["strain"], each.curve["stress_mpa"], label=name)
right.set(xlabel="strain", ylabel="stress, MPa")
right.legend()
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
