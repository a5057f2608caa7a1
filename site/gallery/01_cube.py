"""A cube and its grading

The default specimen of the paper is a cube of 150 mm. A smaller one packs in a moment.
"""
import mesocrete as mc

packing = mc.pack({"specimen": mc.Specimen.cube(60)}, fraction=0.45, seed=1)
print(packing)
for size in packing.report()["classes"]:
    print(f"{size['d_min_mm']:g} to {size['d_max_mm']:g} mm: {size['fraction']:.4f} of {size['target_fraction']:.4f}")

# The report compares every class with its target. `check` proves the packing anew, from its coordinates alone.
print(packing.check()["sound"])

# A picture needs the extra `plot`: `pip install "mesocrete[plot]"`.
packing.plot(screenshot="picture.png")
