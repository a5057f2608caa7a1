"""Fibres and voids

Straight fibres and spherical voids are further phases. They are placed together with the aggregates, without overlap.
"""
import pyvista

import mesocrete as mc

spec = {
    "specimen": mc.Specimen.prism(80, 40, 40),
    "grading": mc.Grading.fuller(5, 12),
    "fibres": {"fraction": 0.005, "diameter_mm": 0.8, "length_mm": 20.0},
    "voids": {"fraction": 0.01, "diameter_mm": [2.0, 4.0]},
}
packing = mc.pack(spec, fraction=0.25, seed=6)
phases = [body.phase for body in packing.inclusions]
print({phase: phases.count(phase) for phase in sorted(set(phases))})

# Surfaces have the phase of their body: 2 aggregate, 3 void, 4 fibre. The aggregates are drawn as glass.
surface = packing.to_pyvista()
plotter = pyvista.Plotter(off_screen=True)
packing.plot(plotter=plotter, opacity=0.1)
plotter.add_mesh(surface.extract_cells(surface.cell_data["phase"] == 4), color="#2f3b4c")
plotter.add_mesh(surface.extract_cells(surface.cell_data["phase"] == 3), color="#c48b9f")
plotter.screenshot("picture.png")
