"""Collision alone

`mc.gjk` decides whether two convex bodies share a point: certified, for hulls of any dimension. Touching counts.
"""
import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc

cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
print(mc.gjk.intersects(cube, cube + [1, 1, 1]), mc.gjk.intersects(cube, cube + [1 + 1e-15, 0, 0]))
print(mc.gjk.distance(cube, cube + [3, 4, 0]))

# Bodies of a packing go in as they are.
packing = mc.pack({"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(5, 12)}, fraction=0.3, seed=1)
grains = list(packing.aggregates)
gaps = np.array([min(mc.gjk.distance(grain, other) for other in grains if other is not grain) for grain in grains[:30]])
assert (gaps > 0).all()

figure, axes = plt.subplots(figsize=(6, 4))
axes.hist(gaps, bins=15)
axes.set(xlabel="distance to the nearest grain, mm", ylabel="grains")
figure.savefig("picture.png", dpi=120)
