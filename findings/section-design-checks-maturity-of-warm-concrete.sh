#!/usr/bin/env bash
# section-design-checks 0.1.0: the maturity by Nurse and Saul is that of a concrete which hardens slower where it is warmer.
# saul_maturity_coefficient() has (Tr + 11) / (T + 11), the reverse of the rate (T + 11) / (Tr + 11) that multiplies a time.
# Its siblings by Sadgrove and by Arrhenius rise with the temperature; all three go into the same sum.
# Seen: at 40 degrees it is 0.61, at 10 degrees 1.48; right are 1.65 and 0.68. At the reference of 20 degrees all have 1.
# 72 adiabatic hours of a mix with 350 kg of cement, which heats from 20 to 73 degrees, count as 32 hours by saul_maturity(),
# as 356 by sadgrove_maturity() and as 453 by arrhenius_maturity() with 33.5 kJ/mol; the rate above has 171.
# Fix: an own sum of (T + 11) / (Tr + 11) over make_time_temps_dict().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile section-design-checks==0.1.0 pydantic==2.14.4 shapely==2.2.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from section_design_checks.reinforced_concrete.thermal import AdiabaticTemperature, Binder, ConcreteMix

mix = ConcreteMix(cement_content=350, concrete_placing_temp=20, binder=Binder())
model = AdiabaticTemperature(mix=mix, time_elapsed=72.0)
energy = 33500


def rate(temperature):
    return (temperature + 11) / (model.test_mix_temp + 11)


print("section-design-checks", importlib.metadata.version("section-design-checks"))
for degrees in (10, 20, 40):
    saul = model.saul_maturity_coefficient(degrees)
    sadgrove = model.sadgrove_maturity_coefficient(degrees)
    arrhenius = model.arrhenius_maturity_coefficient(degrees, energy)
    print(f"  {degrees} degrees: Saul {saul:.3f}, right {rate(degrees):.3f}, Sadgrove {sadgrove:.3f}, Arrhenius {arrhenius:.3f}")
    assert np.isclose(saul * rate(degrees), 1)
    assert np.sign(sadgrove - 1) == np.sign(arrhenius - 1) == np.sign(degrees - 20) == -np.sign(saul - 1)
course = model.make_time_temps_dict(50)
times, degrees = np.array(course["time"]), np.array(course["adiabatic_temps"])
middle = (degrees[1:] + degrees[:-1]) / 2
right, seen = float(np.sum(np.diff(times) * rate(middle))), model.saul_maturity()
others = model.sadgrove_maturity(), model.arrhenius_maturity(energy)
print(f"  72 hours up to {degrees[-1]:.1f} degrees: Saul {seen:.1f}, right {right:.1f}, others", np.round(others, 1))
assert np.isclose(seen, np.sum(np.diff(times) / rate(middle)))
assert seen < 36 < 72 < 144 < right < min(others)
PYTHON
