"""Your own sieve curve

A sieve table is two arrays: openings in mm, and the share by volume that passes each. Sizes are those of square holes.
"""
import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc

sieve_mm = np.array([4.0, 5.6, 8.0, 11.2, 16.0])
passing = np.array([0.30, 0.42, 0.60, 0.78, 1.0])
grading = mc.Grading.sieves(sieve_mm, passing, d_min_mm=4, d_max_mm=16)
packing = mc.pack({"specimen": mc.Specimen.cube(70), "grading": grading}, fraction=0.35, seed=2)

# The part of the curve below the smallest aggregate is mortar; the rest is normalised.
figure, axes = plt.subplots(figsize=(6, 4))
packing.plot_grading(ax=axes)
figure.savefig("picture.png", dpi=120)
