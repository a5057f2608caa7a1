#!/usr/bin/env bash
# pyNastran 1.4.1: Volume() of bricks, prisms and pyramids takes the way between two centroids for the height.
# It is right where that way is normal to the faces alone. mass_properties() has its masses from it. CTETRA is right.
# Seen: a unit brick sheared by 45 degrees has a volume and a mass of 1.414, not 1; a prism and a pyramid are as far off.
# The same brick with its nodes numbered from a face along the shear has 1.
# Mends it: the volume of tetrahedra into which each element is cut.
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

brick = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
shapes = {
    "chexa": (brick, [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]),
    "cpenta": (brick[[0, 1, 3, 4, 5, 7]], [[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5]]),
    "cpyram": (np.vstack([brick[:4], [[0.5, 0.5, 1]]]), [[0, 1, 2, 4], [0, 2, 3, 4]]),
    "ctetra": (brick[[0, 1, 3, 4]], [[0, 1, 2, 3]]),
}
shear = np.array([[1, 0, 0], [0, 1, 0], [1, 0, 1]])


def seen(card, points):
    model = BDF(debug=None)
    for number, point in enumerate(points, 1):
        model.add_grid(number, point)
    getattr(model, "add_" + card)(1, 1, list(range(1, len(points) + 1)))
    model.add_psolid(1, 1)
    model.add_mat1(1, 30e3, None, 0.2, rho=1.0)
    model.cross_reference()
    mass = mass_properties(model)[0]
    assert np.isclose(mass, model.elements[1].Volume())
    return mass


factors = {}
for card, (points, cut) in shapes.items():
    for sheared, own in ((False, points), (True, points @ shear)):
        right = sum(abs(np.linalg.det(own[tetra[1:]] - own[tetra[0]])) for tetra in cut) / 6
        factors[card, sheared] = seen(card, own) / right
other_face = seen("chexa", (brick @ shear)[[0, 4, 5, 1, 3, 7, 6, 2]])
factors = {key: round(float(factor), 6) for key, factor in factors.items()}
print("pyNastran", pyNastran.__version__, "seen by right:", factors, "other face:", round(float(other_face), 6))
for (card, sheared), factor in factors.items():
    assert np.isclose(factor, 2**0.5 if sheared and card != "ctetra" else 1)
assert np.isclose(other_face, 1)
PYTHON
