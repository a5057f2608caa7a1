"""A cylinder of a standard

`mc.recipes()` lists the specimens of the EN, ASTM, GB and RILEM tests. A recipe is a spec that can be changed.
"""
import mesocrete as mc

for name, title in mc.recipes().items():
    print(f"{name:18} {title}")

# Half the size of the real one, so that this page is quick.
spec = mc.Spec.recipe("astm-cylinder-100").replace(
    specimen=mc.Specimen.cylinder(50, 100), grading=mc.Grading.fuller(4, 12), fraction=0.35
)
packing = mc.pack(spec, seed=3)
print(packing.fraction, len(packing))
packing.plot(screenshot="picture.png")
