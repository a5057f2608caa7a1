"""The curve of @DECK@, from the job's results.

    abaqus python THIS_FILE NAME.odb [curve.csv]

It writes strain, stress over the specimen's section, and energies, with the columns of `mesocrete solve`: strain and stress are
positive in the test's own sense, stresses in MPa, energies in mJ. It runs in the Python of every Abaqus (2.7 and 3).
"""
from __future__ import print_function

import sys

HEIGHT_MM = @HEIGHT@
SECTION_MM2 = @SECTION@
# Reference nodes of the supports at the lower and at the upper end, and the axis that they move along.
LOWER_NODES = @LOWER@
UPPER_NODES = @UPPER@
AXIS = @AXIS@
# -1 where the path presses the specimen, 1 where it pulls.
SENSE = @SENSE@

ENERGIES = [
    ("kinetic", "ALLKE"),
    ("internal", "ALLIE"),
    ("external", "ALLWK"),
    ("friction_work", "ALLFD"),
    ("hourglass", "ALLAE"),
]


def read(name):
    """The curve of an .odb."""
    from odbAccess import openOdb

    odb = openOdb(path=name, readOnly=True)
    try:
        return curve(odb)
    finally:
        odb.close()


def curve(odb):
    """Rows of strain, stress and energies over the step of the path; the lower supports, which rest or pull, give the stress."""
    regions = list(odb.steps.values())[-1].historyRegions
    lower = [at_node(regions, node) for node in LOWER_NODES]
    upper = [at_node(regions, node) for node in UPPER_NODES]
    ends = [[output(plate, "U%d" % AXIS) for plate in plates] for plates in (lower, upper)]
    forces = [output(plate, "RF%d" % AXIS) for plate in lower]
    energies = [model_output(regions, name) for _, name in ENERGIES]

    def way(time):
        low, high = [sum(interpolated(plate, time) for plate in plates) / len(plates) for plates in ends]
        return high - low

    times = [time for time, _ in forces[0]]
    rows = []
    for time in times:
        # The loads before the path have moved the plates; no minus before a zero.
        strain = SENSE * (way(time) - way(times[0])) / HEIGHT_MM + 0.0
        stress = -SENSE * sum(interpolated(force, time) for force in forces) / SECTION_MM2 + 0.0
        rows.append([strain, stress] + [interpolated(energy, time) for energy in energies])
    return rows


def at_node(regions, number):
    """The history of a node; its region is called after its number."""
    for name, region in regions.items():
        if name.startswith("Node ") and name.rsplit(".", 1)[-1] == str(number):
            return region
    raise SystemExit("the .odb has no history of node %d: is it of this deck?" % number)


def output(region, name):
    """A variable's (time, value) pairs; a filtered one has the filter's name behind its own."""
    for key in region.historyOutputs.keys():
        if key == name or key.startswith(name + "_"):
            return region.historyOutputs[key].data
    return None


def model_output(regions, name):
    """An energy of the whole model, all zero where the .odb has none."""
    for region in regions.values():
        data = output(region, name)
        if data is not None:
            return data
    return ((0.0, 0.0),)


