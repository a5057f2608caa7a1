"""Wrong combinations of options are refused by their keywords, as tests/cli/refusals.rs has them by flag and by file."""

import json
from pathlib import Path

import pytest

import mesocrete as mc

REFUSALS = json.loads((Path(__file__).parents[1] / "refusals.json").read_text(encoding="utf-8"))
# Lengths of a mesh and of voxels have no unit in their keywords.
KEYWORDS = {"element_size_mm": "element_size", "voxel_size_mm": "voxel_size"}


@pytest.fixture(scope="module")
def packing():
    return mc.pack(mc.Spec(specimen=mc.Specimen.cube(40), fraction=0.2, seed=1))


@pytest.fixture(scope="module")
def meshes(packing):
    return {method: packing.mesh(method=method, element_size=5, accept_phase_error=True) for method in ("voxel", "lattice")}


def refused(row, packing, meshes, path):
    options = {KEYWORDS.get(key, key): value for key, value in row["options"].items()}
    match row["verb"]:
        case "mesh":
            packing.mesh(**options)
        case "deck":
            meshes[options.pop("method", "voxel")].write(path, **options)
        case "solve":
            meshes["lattice"].solve(options.pop("test", "compression"), **options)
        case "effective":
            packing.effective(**options)


@pytest.mark.parametrize("row", REFUSALS, ids=lambda row: f"{row['verb']}-{'-'.join(row['options'])}")
def test_a_wrong_combination_is_refused_by_its_keyword(row, packing, meshes, tmp_path):
    with pytest.raises((ValueError, TypeError)) as caught:
        refused(row, packing, meshes, tmp_path / "m.inp")
    name = KEYWORDS.get(row["wrong"], row["wrong"])
    assert str(caught.value).startswith(f"{name} {row['said']}")
    assert not list(tmp_path.iterdir())
