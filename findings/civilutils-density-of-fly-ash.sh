#!/usr/bin/env bash
# civilutils 0.1.1: compute_mix_design() takes fly ash for as light as water, whatever its specific gravity is.
# It is given as Materials.FLY_ASH, as are those of the other materials, and is looked up as MineralAdmixture.FLY_ASH; where
# that is not found, 1.0 is taken without a message.
# Seen: an M40 with 136 kg of fly ash of 2.2 per cubic metre reports a volume of 0.136 m3 for it, not 0.062; the masses
# that should fill 1 m3 fill 0.926 m3. A mix without fly ash fills 1 m3 within its rounding to litres.
# The summary has the text "self.target_mean_compressive_strength" in place of that strength, and likewise for the ratio of
# water to cement. A mix without an admixture has one all the same, 2 % of the cement.
# Fix: SpecificGravity(MineralAdmixture.FLY_ASH, 2.2).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps civilutils==0.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

from civilutils.indian_standards import concrete

gravities = {"CEMENT": 3.15, "FLY_ASH": 2.2, "WATER": 1.0, "ADMIXTURE": 1.145, "FINE_AGGREGATE": 2.65, "COARSE_AGGREGATE": 2.74}
given = [concrete.SpecificGravity(concrete.Materials[name], value) for name, value in gravities.items()]
ash = concrete.MineralAdmixture.FLY_ASH


def mix(mineral, listed):
    design = concrete.ConcreteMixDesign(
        concrete.ConcreteGrade.M40,
        concrete.ExposureCondition.SEVERE,
        listed,
        is_pumpable=False,
        mineral_admixture=mineral,
    ).compute_mix_design()
    parts = design["mix_per_m3"]["components"]
    return design["summary"], parts, sum(part["mass_kg"] / gravities[name.upper()] for name, part in parts.items()) / 1000


print("civilutils", importlib.metadata.version("civilutils"))
_, plain, whole = mix(None, given)
summary, parts, filled = mix(ash, given)
_, mended, again = mix(ash, given + [concrete.SpecificGravity(ash, gravities["FLY_ASH"])])
print("  without fly ash:", round(whole, 4), "m3, admixture:", round(plain["admixture"]["mass_kg"], 2), "kg")
print("  with:", round(filled, 4), "m3,", parts["fly_ash"], "summary:", summary)
print("  given as MineralAdmixture.FLY_ASH:", round(again, 4), "m3,", mended["fly_ash"])
assert parts["fly_ash"]["specific_gravity"] == 1 and mended["fly_ash"]["specific_gravity"] == 2.2
assert parts["fly_ash"]["mass_kg"] == mended["fly_ash"]["mass_kg"] == 136
assert abs(whole - 1) < 0.002 and abs(again - 1) < 0.002 and filled < 0.93
assert summary["target_mean_strength_N_per_mm2"] == "self.target_mean_compressive_strength"
assert abs(plain["admixture"]["mass_kg"] - 0.02 * plain["cement"]["mass_kg"]) < 1e-9
PYTHON
