#!/usr/bin/env bash
# fconcrete 0.1.1.6: concrete above C50 has less than half of its tensile strength, and any concrete 10 times its stiffness.
# NBR 6118 (8.2.5) has fctm = 2.12 ln(1 + 0.11 fck) above 50 MPa, as Eurocode 2 has with fcm in place of fck; the logarithm here
# is that of base 10. fctk and fctd, minimum stirrups and the moment of cracking follow from it. E_cs in MPa is given on as a
# number in kN/cm2, so that material.E, which beams take, is 10 times the attribute E_cs.
# Seen: fctm of C50, C51, C60 and C90 is 4.07, 1.74, 1.87 and 2.20 MPa; right are 4.07, 4.00, 4.30 and 5.06. E of C30 is 26 838
# kN/cm2 with an E_cs of 2684 kN/cm2, and a beam of it sags 0.0060 cm; right by 5 q L^4 / 384 E I is 0.0596. No message.
# Its pins of 2020 have no wheels for a current Python; the units, which are read by a newer pint here, are asserted.
# Fix: own values in material.fctm and the like; fc.Material("26838MPa", 0.2, 1e-5) for beams.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
pip() { "$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps "$@"; }
pip setuptools==79.0.1 wheel==0.45.1
pip --no-build-isolation fconcrete==0.1.1.6 pint==0.20.1 ezdxf==0.11.1 click==8.5.1 pandas==2.2.3 pytz==2026.6 python-dateutil==2.9.0.post0 six==1.17.0 matplotlib==3.9.4 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 numpy==1.26.4
cd "$folder"
MPLBACKEND=Agg "$folder/venv/bin/python" -W ignore - <<'PYTHON'
import importlib.metadata
from math import log

import fconcrete as fc
import numpy as np

print("fconcrete", importlib.metadata.version("fconcrete"))
assert fc.helpers.to_unit("10cm", "m") == 0.1 and fc.helpers.to_unit(20, "MPa", "kN/cm**2") == 2
strengths = {}
for fck in (20, 30, 50, 51, 60, 90):
    right = 0.3 * fck ** (2 / 3) if fck <= 50 else 2.12 * log(1 + 0.11 * fck)
    eurocode = right if fck <= 50 else 2.12 * log(1 + (fck + 8) / 10)
    seen = 10 * fc.Concrete(fck, 2).fctm
    strengths[fck] = seen, right
    print(f"  C{fck}: fctm {seen:.2f} MPa, right {right:.2f}, Eurocode 2 {eurocode:.2f}")
    assert np.isclose(seen, right if fck <= 50 else right / log(10)) and np.isclose(right, eurocode, rtol=0.04)
assert strengths[90][0] < strengths[20][0] < strengths[50][0]


def sag(material):
    beam = fc.Beam(
        loads=[fc.Load.UniformDistributedLoad(-0.1, x_begin=0, x_end=400)],
        beam_elements=[
            fc.BeamElement([fc.Node.SimpleSupport(x=0), fc.Node.SimpleSupport(x=400)], section=section, material=material)
        ],
    )
    return -float(beam.getDisplacement(200))


section = fc.Rectangle(20, 50)
concrete = fc.Concrete(30, 2)
right = 5 * 0.1 * 400**4 / (384 * concrete.E_cs * section.I)
given = fc.Material(f"{10 * concrete.E_cs}MPa", 0.2, 1e-5)
own, mended = sag(concrete), sag(given)
print(f"  C30: E {concrete.E:.1f}, E_cs {concrete.E_cs:.1f} kN/cm2; given as text {given.E:.1f}")
print(f"  a beam of it sags {own:.5f} cm, of the given material {mended:.5f}, right {right:.5f}")
assert np.isclose(concrete.E_cs, 0.875 * 5600 * 30**0.5 / 10) and np.isclose(concrete.E, 10 * concrete.E_cs)
assert np.isclose(own, right / 10, rtol=1e-4) and np.isclose(mended, right, rtol=1e-4) and np.isclose(given.E, concrete.E_cs)
PYTHON
