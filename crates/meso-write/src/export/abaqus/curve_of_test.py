# Reference nodes of the supports at the lower and at the upper end, and the axis that they move along.
LOWER_NODES = @LOWER@
UPPER_NODES = @UPPER@
AXIS = @AXIS@


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


