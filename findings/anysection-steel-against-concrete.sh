#!/usr/bin/env bash
# anysection 1.0.0: a compressed column gets weaker with reinforcement, since concrete and steel have opposite signs.
# The stress of concrete is positive where its strain is negative, in compression; that of steel has the sign of its strain.
# SectionSolver adds both, in the axial force and in the moment. The sign of no argument changes that.
# Seen: a column of 0.4 m x 0.4 m, all of it at a strain of -0.002, carries 4.80 MN as plain concrete, 3.23 MN with eight
# bars of 25 mm and 1.66 MN with sixteen; right are 6.37 and 7.94, as bars replace no concrete here. A section with bars in
# its zone of tension only has a positive force at every neutral axis, so that its moment is None at every curvature.
# Tee() has its parts hw apart, not (hf + hw) / 2, and its web (bf - bw) / 2 off the middle of the flange: 400 x 100 mm on
# 200 x 300 mm has a second moment of 2643e6 mm4, right is 1443e6.
# Fix: a material whose stress() is that of concrete times -1; a CompositeArea of two Rectangle().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps anysection==1.0.0 numpy==2.2.3
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import contextlib
import importlib.metadata
import io
import math

import numpy as np
from anysection.area import Tee
from anysection.material import Concrete_NonlinearEC2, Steel_Bilinear
from anysection.section import Section
from anysection.solver import SectionSolver

concrete, steel = Concrete_NonlinearEC2(fcm=30e6, ec1=0.002, ecu1=0.0035), Steel_Bilinear(Es=200e9, fy=500e6, euk=0.05)
bar, side, strain = math.pi * 0.025**2 / 4, 0.4, -0.002


def column(bars, heights=(-0.16, 0.16)):
    section = Section("column")
    for y in (np.arange(40) + 0.5) / 40 * side - side / 2:
        section.add_fiber(side**2 / 40, 0.0, y, concrete)
    for number in range(bars):
        section.add_fiber(bar, 0.0, heights[number % len(heights)], steel)
    return SectionSolver(section)


print("anysection", importlib.metadata.version("anysection"))
far = 1e6  # the strain of a fiber is the curvature times its distance to the neutral axis
forces = {bars: column(bars).calculate_axial_force(far, -strain / far) for bars in (0, 8, 16)}
for bars, force in forces.items():
    right = concrete.fcm * side**2 + bars * bar * min(steel.fy, steel.Es * -strain)
    print(f"  {bars} bars: {force / 1e6:.3f} MN, right: {right / 1e6:.3f} MN")
    assert math.isclose(force, 2 * forces[0] - right, rel_tol=1e-6)
with contextlib.redirect_stdout(io.StringIO()):
    curve = column(4, heights=(0.16,)).moment_curvature_analysis([0.001, 0.005, 0.02])
print("  four bars at the bottom, curvature and moment:", curve)
assert [moment for _, moment in curve] == [None] * 3
tee = Tee(bf=400, hf=100, bw=200, hw=300)
middle = (400 * 100 * 350 + 200 * 300 * 150) / tee.area()
right = 400 * 100**3 / 12 + 200 * 300**3 / 12 + 400 * 100 * (350 - middle) ** 2 + 200 * 300 * (150 - middle) ** 2
seen = tee.moment_of_inertia()[0]
print(f"  T of 400 x 100 on 200 x 300: {seen / 1e6:.0f}e6, right: {right / 1e6:.0f}e6, centroid {tee.centroid()}")
assert tee.area() == 1e5 and round(seen / 1e6) == 2643 and round(right / 1e6) == 1443
PYTHON
