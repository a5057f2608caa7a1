"""Wrong combinations of options are refused by their keywords, as tests/cli/refusals.rs has them by flag and by file."""

import json
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

REFUSALS = json.loads((Path(__file__).parents[1] / "refusals.json").read_text(encoding="utf-8"))
# Lengths and the time limit have no unit in their keywords; a TEST.toml's own have.
KEYWORDS = {"element_size_mm": "element_size", "voxel_size_mm": "voxel_size", "time_limit_s": "time_limit"}
KEYWORDS |= {key: key.removesuffix("_mm") for key in ("min_gap_mm", "gap_mm", "itz_thickness_mm")}
CURVE = [(0, 0), (5e-4, 10), (1e-3, 20), (2e-3, 30), (3e-3, 25), (4e-3, 15)]


@pytest.fixture(scope="module")
def packing():
    return mc.pack(mc.Spec(specimen=mc.Specimen.cube(40), fraction=0.2, seed=1))


@pytest.fixture(scope="module")
def meshes(packing):
    return {method: packing.mesh(method=method, element_size=5, accept_phase_error=True) for method in ("voxel", "lattice")}


def keyword(verb, key):
    return "h" if (verb, key) == ("image", "voxel_size_mm") else KEYWORDS.get(key, key)


def refused(row, packing, meshes, path):
    options = {keyword(row["verb"], key): value for key, value in row["options"].items()}
    match row["verb"]:
        case "mesh":
            packing.mesh(**options)
        case "deck":
            meshes[options.pop("method", "voxel")].write(path, **options)
        case "solve":
            meshes["lattice"].solve(options.pop("test", "compression"), **options)
        case "effective":
            packing.effective(**options)
        case "pack":
            mc.pack(packing.spec, **options)
        case "convert":
            packing.write(path.with_name(row["output"]), **options)
        case "image":
            packing.voxelize(**options)
        case "import":
            mc.from_labels(np.eye(20, dtype=int)[None].repeat(20, 0), **options)
        case "fit":
            mc.fit(CURVE, packing.spec, out=path, **options)
        case "init":
            mc.Materials.for_concrete(options.pop("materials"), **options)
        case "study":
            mc.study(packing.spec, {"seed": [1]}, out=path, **options)
        case "dataset":
            mc.dataset(options.pop("n", 1), spec=packing.spec, sink=path, **options)


@pytest.mark.parametrize("row", [row for row in REFUSALS if row.get("by") != "flag"], ids=lambda row: f"{row['verb']}-{'-'.join(row['options'])}")
def test_a_wrong_combination_is_refused_by_its_keyword(row, packing, meshes, tmp_path):
    with pytest.raises((ValueError, TypeError)) as caught:
        refused(row, packing, meshes, tmp_path / "m.inp")
    name = keyword(row["verb"], row["wrong"])
    assert str(caught.value).startswith(f"{name} {row['said']}")
    assert not list(tmp_path.iterdir())


def test_sizes_that_are_no_numbers_have_their_keywords_and_other_formats_no_keywords_of_a_deck(packing, meshes, tmp_path):
    with pytest.raises(ValueError, match="^voxel_size is NaN; it must be finite"):
        packing.effective(voxel_size=float("nan"))
    with pytest.raises(ValueError, match="^h is NaN; it must lie within"):
        packing.voxelize(float("nan"))
    # The case: an .xdmf took any keyword without a word.
    refused = [
        ({"test": "tension"}, "only an .inp or a .k takes keywords of a deck"),
        ({"oops": 1}, "oops is not a known key"),
        ({"compress": True}, "^compress is true; only a .vtu"),
    ]
    for options, message in refused:
        with pytest.raises(ValueError, match=message):
            meshes["lattice"].write(tmp_path / "m.xdmf", **options)
    assert not list(tmp_path.iterdir())
