#!/usr/bin/env bash
# frppy 0.1.0: frp_shear_strengthening() has U-wraps and strips on two sides the wrong way round in two factors.
# ACI 440.2R-17 has k2 = (dfv - Le) / dfv for a U-wrap, each leg of which has one free end, and (dfv - 2 Le) / dfv for strips
# on two sides, which have two; here it is the reverse. psi is 0.85 for both, and 0.95 for a section that is wrapped all
# around; a U-wrap has 0.95 here.
# Seen: at an effective depth of 400 mm a U-wrap carries 67.7 kN and the same strips without the lower part 79.4 kN; right are
# 79.4 and 67.7. At 200 mm they are 22.0 and 33.8. The design strength of two sides is above that of a U-wrap, too, in spite
# of psi.
# Fix: "S" for a U-wrap; "U" and 0.85 / 0.95 of the design strength for two sides.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps frppy==0.1.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import math

import frppy

beam = dict(n=1, tf=0.165, wf=254, sf=305, Ef=228000, eps_fu_star=0.017, CE=0.95, alpha=90, fc=20.7)


def right(depth, free_ends):
    rupture = beam["CE"] * beam["eps_fu_star"]
    bonded = 23300 / (beam["n"] * beam["tf"] * beam["Ef"]) ** 0.58
    k1, k2 = (beam["fc"] / 27) ** (2 / 3), (depth - free_ends * bonded) / depth
    strain = min(0.004, 0.75 * rupture, k1 * k2 * bonded / 11900)
    return 2 * beam["n"] * beam["tf"] * beam["wf"] * strain * beam["Ef"] * depth / beam["sf"] / 1000


print("frppy", importlib.metadata.version("frppy"))
for depth in (400, 200):
    seen = {wrap: frppy.frp_shear_strengthening(dfv=depth, wrap=wrap, **beam) for wrap in "US"}
    for name, wrap, ends in (("U-wrap", "U", 1), ("two sides", "S", 2)):
        forces = {key: round(seen[wrap][key], 2) for key in ("Vf", "psi", "phi_Vnf")}
        print(f"  {depth} mm, {name}: {forces}, right Vf: {right(depth, ends):.2f}")
        assert math.isclose(seen[wrap]["Vf"], right(depth, 3 - ends), rel_tol=1e-9)
    assert seen["U"]["Vf"] < seen["S"]["Vf"] and seen["U"]["phi_Vnf"] < seen["S"]["phi_Vnf"]
    assert (seen["U"]["psi"], seen["S"]["psi"]) == (0.95, 0.85)
PYTHON
