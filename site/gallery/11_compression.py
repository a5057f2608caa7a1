"""A compression test

The whole test in three lines: pack, mesh, crush. [The solver](../solve.md) has the laws and their limits. This specimen and its
elements are too coarse to trust; they keep the page quick.
"""
import matplotlib.pyplot as plt

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(8, 14), "placement": {"min_gap_mm": 1.0}}
packing = mc.pack(spec, fraction=0.25, seed=1)
mesh = packing.mesh(for_test=True, element_size=4.0)
response = mesh.solve(test="compression", friction=0.1, strain=0.006)
print({key: response.result[key] for key in ("peak_mpa", "peak_strain", "modulus_mpa", "softened")})
print(f"{response.result['seconds']['total']:.0f} s")

figure, axes = plt.subplots(figsize=(6, 4))
response.plot(ax=axes)
figure.savefig("picture.png", dpi=120)
