#!/usr/bin/env bash
# CALFEM for Python 3.6.16: with the integration rule 3, flw3i8e() has all 27 points in one layer near the lower face.
# Conductivities and loads come from there alone, with 5/6 of the volume; flw3i8s() has the same points.
# Seen: a unit cube conducts 0.833, not 1, along each axis, and its lower nodes take 0.739 of a supply of 0.833, the upper
# ones 0.094; each half should have 0.5. The rule 2 is right, and so is the rule 3 of soli8e().
# Mends it: the rule 2.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps calfem-python==3.6.16 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import calfem.core
import numpy as np

cube = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
flows = {}
for rule in (2, 3):
    stiffness, load = calfem.core.flw3i8e(*cube.T, [rule], np.eye(3), [1.0])
    points = np.asarray(calfem.core.flw3i8s(*cube.T, [rule], np.eye(3), cube[:, 0])[2])
    # The field x has the gradient 1, so that its energy is the conductivity times the volume.
    energies = [round(float(x @ np.asarray(stiffness) @ x), 3) for x in cube.T]
    below, above = np.ravel(load)[:4].sum(), np.ravel(load)[4:].sum()
    flows[rule] = energies, round(float(below), 3), round(float(above), 3), len(np.unique(points[:, 2].round(6)))
    print(" rule", rule, "conducts", energies, "supply below, above and layers of points:", *flows[rule][1:])
elastic = calfem.core.hooke(4, 30.0, 0.2)
solid, weight = calfem.core.soli8e(*cube.T, [3], elastic, np.array([0, 0, 1.0]))
stretch = np.ravel(cube * [1, 0, 0])
energy = float(stretch @ np.asarray(solid) @ stretch)
print("CALFEM", importlib.metadata.version("calfem-python"), "soli8e:", round(energy, 3), "right:", round(elastic[0, 0], 3))
assert flows[2] == ([1.0] * 3, 0.5, 0.5, 2)
assert flows[3] == ([0.833] * 3, 0.739, 0.094, 1)
assert np.isclose(energy, elastic[0, 0]) and np.isclose(np.sum(weight), 1)
PYTHON
