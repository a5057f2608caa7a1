#!/usr/bin/env bash
# pyhom 1.0.7: Cell_Props_From_TensorP_PCW() turns a tensor by a matrix that is no rotation: both sines have the same sign.
# It should give back the aspect ratio and the angle of an elliptical cell from its Hill tensor, which is how
# All_Calc() reports the cell of the Ponte Castaneda and Willis scheme. Rotate() of the same class has the signs right.
# Seen: the Hill tensor of a cell of aspect ratio 2 at 0.5 rad comes back as 1.46 at 0.14 rad, without a message.
# At an angle of 0 it is right. The eigenvalues of the tensor, which no rotation changes, have the ratio of 2.
# Fix: the ratio of the eigenvalues and the direction of the eigenvectors.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps pyhom==1.0.7 sympy==1.12.1 mpmath==1.3.0 scipy==1.13.1 matplotlib==3.9.0 numpy==1.26.4 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from pyhom.mean_field.MF_Hom import Mean_Field_Approaches as approaches

for angle, right in ((0.0, True), (0.5, False), (-0.5, False)):
    plain = approaches.P_Cell(np.array([[2.0]]), 1.0)
    hill = approaches.Rotate(plain, np.array([[angle]]))[:, :, 0]
    low, high = np.linalg.eigvalsh(hill)
    ratio, turned = (float(x) for x in approaches.Cell_Props_From_TensorP_PCW(hill, 1.0))
    print(" angle", angle, "comes back as", round(turned, 3), "ratio", round(ratio, 3), "of eigenvalues", round(high / low, 3))
    assert np.isclose(high / low, 2)
    if right:
        assert np.isclose(ratio, 2) and np.isclose(turned, 0, atol=1e-6)
    else:
        assert np.isclose(ratio, 1.462, atol=1e-3) and np.isclose(turned, np.sign(angle) * 0.142, atol=1e-3)
print("pyhom", importlib.metadata.version("pyhom"))
PYTHON
