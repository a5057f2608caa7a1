"""The curve of @DECK@, from the job's results.

    pip install lasso-python
    python THIS_FILE "binout*" [curve.csv]

It writes strain, stress over the specimen's section, and energies, with the columns of `mesocrete solve`: strain and stress are
positive in the test's own sense, stresses in MPa, energies in mJ. The names within a binout are those of LSTC's own reader, l2a.
"""
from __future__ import print_function

import os
import sys

DECK = "@DECK@"
LENGTH_MM = @HEIGHT@
SECTION_MM2 = @SECTION@
# Where the forces of the supports at the lower end are, the numbers of their contacts or node sets, and their axis from 1.
LOWER = @LOWER@
AXIS = @AXIS@
# Times that the loads and then the path take, s, and where the path turns, mm.
LEAD_S = @LEAD@
DURATION_S = @DURATION@
PATH_MM = @PATH@

ENERGIES = [
    ("kinetic", "kinetic_energy"),
    ("internal", "internal_energy"),
    ("external", "external_work"),
    ("friction_work", "sliding_interface_energy"),
    ("hourglass", "hourglass_energy"),
]


def read(name):
    """The curve of the binout files that a name or a pattern means."""
    from lasso.dyna import Binout

    binout = Binout(name)
    forces = [force(binout, place, number) for place, number in LOWER]
    energies = [list(zip(binout.read("glstat", "time"), binout.read("glstat", energy))) for _, energy in ENERGIES]
    # Half a step of the output early, since a binout may have single precision.
    times = [time for time, _ in forces[0] if time >= LEAD_S - 1e-3 * DURATION_S]
    rows = []
    for time in times:
        stress = sum(interpolated(support, time) for support in forces) / SECTION_MM2
        rows.append([path(time) / LENGTH_MM, stress] + [interpolated(energy, time) for energy in energies])
    # The files of forces have signs of their own: the largest stress has that of the test.
    if max(rows, key=lambda row: abs(row[1]))[1] < 0.0:
        for row in rows:
            row[1] = -row[1] + 0.0
    return rows


def force(binout, place, number):
    """Pairs of time and force of a support along the axis."""
    at = place.split("/")
    ids = list(binout.read(*at + ["force_ids" if place == "spcforc" else "ids"]))
    if place == "rcforc":
        # Every contact has two sides, and 1 is the plate's.
        sides = binout.read("rcforc", "side")
        rows = [i for i, own in enumerate(ids) if own == number and sides[i] == 1]
        expected = 1
    else:
        nodes = nodes_of(number)
        rows = [i for i, node in enumerate(ids) if node in nodes]
        expected = len(nodes)
    if len(rows) != expected:
        raise SystemExit("the %s of the binout has not the support %d of %s: is it of this deck?" % (place, number, DECK))
    values = binout.read(*at + ["%s_force" % "xyz"[AXIS - 1]])
    times = binout.read(*at + ["time"])
    return [(time, sum(float(values[t][i]) for i in rows)) for t, time in enumerate(times)]


def nodes_of(number):
    """The nodes of a set of the deck, which lies beside this script."""
    nodes, numbers = set(), None
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), DECK)) as file:
        for line in file:
            if line.startswith("*"):
                numbers = [] if line.startswith("*SET_NODE_LIST_TITLE") else None
            elif numbers is not None and not line.startswith("$"):
                numbers.append(line)
                # The title, the set's number, its nodes.
                if len(numbers) > 2 and int(numbers[1][:10]) == number:
                    nodes.update(int(node) for node in line.split())
    return nodes


def path(time):
    """The way along the path at a time, mm: a smooth step for each leg."""
    whole = sum(abs(to - start) for start, to in zip([0.0] + PATH_MM, PATH_MM))
    begun, start = LEAD_S, 0.0
    for to in PATH_MM:
        lasts = DURATION_S * abs(to - start) / whole
        x = min(max((time - begun) / lasts, 0.0), 1.0)
        if x < 1.0:
            return start + (to - start) * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
        begun, start = begun + lasts, to
    return start


