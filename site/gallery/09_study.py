"""A study with its scatter

How much do the number of grains and the largest one scatter, and how many packings does a mean need? `ensemble()` answers
for each fraction; [Studies](../studies.md) has the details.
"""
import matplotlib.pyplot as plt

import mesocrete as mc


def figures(packing: mc.Packing) -> dict[str, float]:
    """Return what is compared."""
    return {"grains": len(packing), "largest_mm3": float(packing.aggregates.volume.max())}


spec = {"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(5, 12)}
study = mc.study(spec, {"fraction": [0.2, 0.3, 0.4], "seed": range(5)}, then=figures, out="study")
ensemble = study.ensemble()
for i, name in enumerate(ensemble["figure"]):
    mean, cv, needed = ensemble["mean"][i], ensemble["cv"][i], ensemble["needed"][i]
    print(f"{ensemble['fraction'][i]} {name:12} {mean:8.1f} +- {100 * cv:.1f} %, known to 1 % from {needed:.0f} packings")

table = study.table()
figure, axes = plt.subplots(figsize=(6, 4))
axes.plot(table["fraction"], table["grains"], "o")
axes.set(xlabel="fraction", ylabel="grains")
figure.savefig("picture.png", dpi=120)
