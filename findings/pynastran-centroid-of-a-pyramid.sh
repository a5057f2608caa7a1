#!/usr/bin/env bash
# pyNastran 1.4.1: Centroid() of a CPYRAM lies at half of its height; that of a pyramid lies at a quarter.
# mass_properties() takes it, so that the centre of gravity of a model with pyramids is off.
# Seen: 0.5, not 0.25, over the base of a pyramid of height 1; a unit cube of three pyramids has its centre at 0.333.
# Mends it: (3 * mean of the four corners + apex) / 4.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile pyNastran==1.4.1 scipy==1.14.1 numpy==1.26.4
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import pyNastran
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
faces = {"x": [1, 5, 6, 2], "y": [3, 2, 6, 7], "z": [7, 6, 5, 4]}


def centre(apex, *bases):
    model = BDF(debug=None)
    for number, point in enumerate([*corners, apex], 1):
        model.add_grid(number, point)
    for number, base in enumerate(bases, 1):
        model.add_cpyram(number, 1, [node + 1 for node in base] + [9])
    model.add_psolid(1, 1)
    model.add_mat1(1, 30e3, None, 0.2, rho=1.0)
    model.cross_reference()
    mass, own = mass_properties(model)[:2]
    return float(mass), own.round(4).tolist()


# The layer at the height z of a pyramid of height 1 has the area (1 - z)^2, so that its centroid is at 1/12 over 1/3.
one = centre([0.5, 0.5, 1], [0, 1, 2, 3])
# Three pyramids over the faces that do not touch a corner fill the cube, whose centroid is its middle.
cube = centre([0.0, 0.0, 0.0], *faces.values())
print("pyNastran", pyNastran.__version__, "centre of a pyramid:", one[1], "and of a cube cut into three:", cube[1])
assert np.isclose(one[0], 1 / 3) and one[1] == [0.5, 0.5, 0.5]
assert cube[1] == [0.3333] * 3
PYTHON
