#!/usr/bin/env bash
# rockmechpy 1.0.4: the factor of safety of a Mohr circle that touches the envelope is 1 / cos(phi), not 1.
# It is labelled "theoretical tangency" at 1. The strength is taken below the centre of the circle, where the
# distance to the envelope is measured along tau, and is divided by the radius, which is normal to the envelope.
# Seen: three triaxial tests of a rock with c = 10 MPa and phi = 30 degrees, all at failure, have 1.155 and are "safe",
# whether they come as principal stresses or as s and t. c and phi are right, and so is 1 for the direct shear of that rock.
# A circle 10 % beyond the envelope has 1.05.
# Fix: multiply by cos(phi).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rockmechpy==1.0.4 scipy==1.17.1 matplotlib==3.11.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import matplotlib

matplotlib.use("Agg")
import numpy as np
from rockmechpy.MCenvelope import MCenvelope

c, phi = 10.0, np.radians(30)
least = np.array([0.0, 5.0, 10.0])
most = 2 * c * np.cos(phi) / (1 - np.sin(phi)) + least * (1 + np.sin(phi)) / (1 - np.sin(phi))
normal = np.array([5.0, 10.0, 20.0])
tests = {
    "principal_stress": (least, most),
    "s_t_space": ((least + most) / 2, (most - least) / 2),
    "direct_shear": (normal, c + normal * np.tan(phi)),
}
print("rockmechpy", importlib.metadata.version("rockmechpy"))
for name, (x, y) in tests.items():
    envelope = MCenvelope(x, y, input_type=name)
    envelope.plot_condition()
    print(" ", name, "c, phi:", round(envelope.cohesion, 3), round(envelope.friction_angle, 3), envelope.fos_values.round(4))
    assert np.isclose(envelope.cohesion, c) and np.isclose(envelope.friction_angle, 30)
    assert np.allclose(envelope.fos_values, 1 if name == "direct_shear" else 1 / np.cos(phi))
PYTHON
