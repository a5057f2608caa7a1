"""The random specimens and meshes of `tests/core/matrix.rs`, case for case by their numbers."""

import re
from pathlib import Path

import mesocrete as mc

RUST = Path(__file__).resolve().parents[1] / "core" / "matrix.rs"

SPECIMENS = [
    "{ kind = 'cube', side_mm = 30 }",
    "{ kind = 'cube', side_mm = 30, periodic = ['x', 'y', 'z'] }",
    "{ kind = 'box', size_mm = [24, 30, 36], periodic = ['z'] }",
    "{ kind = 'cylinder', diameter_mm = 30, height_mm = 36 }",
    "{ kind = 'sphere', diameter_mm = 34 }",
    "{ kind = 'notched-prism', length_mm = 60, width_mm = 24, depth_mm = 24, notch_depth_mm = 6, notch_width_mm = 3 }",
]
SHAPES = ["polyhedron", "rounded", "crushed"]
THICKNESSES = ["[0, 0]", "[0.1, 0.5]", "[0.3, 0.3]"]
GAPS = ["0", "0.1", "0.5"]
VOIDS = ["", "", r"[voids]\nfraction = 0.01\ndiameter_mm = [2, 3]\n"]
FIBRES = ["", "", r"[fibres]\nfraction = 0.003\ndiameter_mm = 0.8\nlength_mm = 8\n"]
TEXTS = [SPECIMENS, SHAPES, THICKNESSES, GAPS, VOIDS, FIBRES]

FITTED = {"method": "lattice"}
METHODS = {
    "Method::VOXEL": {"method": "voxel"},
    "Method::Voxel { thin_itz: true, subsamples: 2 }": {"method": "voxel", "thin_itz": True, "subsamples": 2},
    "Method::PLAIN": {"method": "lattice", "fit": "plain"},
    "Method::FITTED": FITTED,
    "Method::FITTED again": FITTED,
    "Method::Lattice { fit: mesh::Fit::Fitted, order: Order::Quadratic }": {"method": "lattice", "order": 2},
}


class Chance:
    """A generator after G. Marsaglia (xorshift64*), as in Rust."""

    def __init__(self, number):
        self.state = number * 0x9E3779B97F4A7C15 % 2**64 | 1

    def of(self, end):
        self.state ^= self.state >> 12
        self.state ^= self.state << 25 & (2**64 - 1)
        self.state ^= self.state >> 27
        return (self.state * 0x2545F4914F6CDD1D % 2**64 >> 16) % end

    def pick(self, options):
        return options[self.of(len(options))]


def case(number):
    """The spec of a case, and the keywords of its mesh."""
    chance = Chance(number)
    specimen, shape, thickness, gap, voids, fibres = (chance.pick(texts) for texts in TEXTS)
    fraction, seed = 0.1 + 0.05 * chance.of(5), chance.of(1000)
    text = f"""fraction = {fraction:.2f}
seed = {seed}
specimen = {specimen}
shape = {{ kind = '{shape}' }}
grading = {{ d_min_mm = 4, d_max_mm = 10 }}
itz = {{ thickness_mm = {thickness} }}
placement = {{ min_gap_mm = {gap}, wall_gap_mm = {gap}, strategy = 'take-and-place', attempts = 300 }}
{(voids + fibres).replace(chr(92) + "n", chr(10))}"""
    method = chance.pick([*METHODS.values()])
    itz = chance.pick(["none"] if "order" in method else ["solid", "cohesive", "smeared", "none"])
    size, joined = chance.pick([1.5, 2.0, 3.0]), chance.pick(["keep", "mortar"])
    volumes, gaps = chance.pick(["fitted", "exact"]), chance.pick(["keep", "split"])
    options = {"element_size": size, "itz": itz, "joined": joined, "volumes": volumes, "narrow_gaps": gaps}
    return mc.Spec.from_toml(text), method | options


def mesh(packing, options):
    """Mesh a packing; options that have no effect on its mesh are refused by name, and left out here."""
    asked = dict(options)
    while True:
        try:
            return packing.mesh(**asked, accept_phase_error=True)
        except ValueError as refused:
            idle = re.match(r"(\w+) is \S+; only ", str(refused))
            if idle is None:
                raise
            del asked[idle[1]]


def meshed(number):
    """The specimen of a case, and its mesh; the mesh is None where no body found a place."""
    spec, options = case(number)
    packing = mc.pack(spec)
    return spec.specimen, mesh(packing, options) if len(packing) + len(packing.inclusions) else None
