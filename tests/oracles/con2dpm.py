"""Curves of CDPM2 at one point, from OOFEM's own implementation (material `con2dpm`), as an oracle for `law::cdpm2`.

    pip install oofem==2.6.0.dev1
    python3 tests/oracles/con2dpm.py [NAME]...   # writes tests/oracles/con2dpm/*.csv, or those of the names

One tetrahedron with its corner at the origin and unit edges along the axes: the displacement of the corner on an axis is a
column of the strain tensor. Strain xx, yy, zz, xy, yz, zx with engineering shears; stress in MPa, tension positive.
"""

import os
import re
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import oofem

E, NU, FC, FT, FB = 26000.0, 0.2, 40.0, 3.0, 1.16 * 40.0
GF, WIDTH = 0.06, 2.0
# Grassl et al. 2013: eccentricity from the biaxial strength (eq. 20), bilinear softening with f_t1 = 0.3 f_t and
# w_f1 = 0.15 w_f, whose area is 0.225 f_t w_f.
EPS = FT / FB * (FB**2 - FC**2) / (FC**2 - FT**2)
ECC = (1 + EPS) / (2 - EPS)
WF = GF / (0.225 * FT)
MATERIAL = (
    f"con2dpm 1 d 0 E {E} n {NU} talpha 0. fc {FC} ft {FT} ecc {ECC:.12f} kinit 0.3 hp 0.01 dilation 0.85 stype 1 "
    f"wf {WF:.12f} asoft 15 efc 1.e-4 helem {WIDTH} yieldtol 1.e-8"
)
# The card of *MAT_273 that a deck of voxels of 1 mm has for this mortar: w_f is for the cube root of a voxel's volume.
CARD = Path(__file__).resolve().parent / "con2dpm" / "card.k"
# Steps that lie between two rows of a file; every corner of a path is a multiple of it.
EVERY = 10
NODES = {1: (0, 0, 0), 2: (1, 0, 0), 3: (0, 1, 0), 4: (0, 0, 1)}
AXES = "xyz"


def time_function(number, points):
    times = " ".join(f"{t:.6f}" for t, _ in points)
    values = " ".join(f"{v:.12e}" for _, v in points)
    return f"PiecewiseLinFunction {number} t {len(points)} {times} f(t) {len(points)} {values}"


def free_sides(axial, steps, lateral=0.0, biaxial=False):
    """Axial strain along its corners; y and z are free to move under `lateral`, or only z where y goes with x."""
    hydrostatic = lateral * (1 - 2 * NU) / E
    points = [(0, 0.0), (10, hydrostatic)]
    for value, number in zip(axial, steps):
        points.append((points[-1][0] + number, value))
    fixed = {1: (1, 2, 3), 2: (2, 3), 3: (1, 3), 4: (1, 2)}
    conditions = [f"dofs {len(d)} {' '.join(map(str, d))} values {len(d)} {'0. ' * len(d)}set {n}" for n, d in fixed.items()]
    conditions = [f"BoundaryCondition {i + 1} loadTimeFunction 1 {c}" for i, c in enumerate(conditions)]
    for node, dof in [(2, 1)] + ([(3, 2)] if biaxial else []):
        conditions.append(
            f"BoundaryCondition {len(conditions) + 1} loadTimeFunction 2 dofs 1 {dof} values 1 1. set {node}"
        )
    for node, place in ((3, "0. {0} 0."), (4, "0. 0. {0}")) if lateral else ():
        conditions.append(
            f"NodalLoad {len(conditions) + 1} loadTimeFunction 3 dofs 3 1 2 3 Components 3 "
            f"{place.format(lateral / 6)} set {node}"
        )
    functions = ["ConstantFunction 1 f(t) 1.", time_function(2, points), time_function(3, [(0, 0), (10, 1), (1e6, 1)])]
    return conditions, functions, int(points[-1][0])


def told(strains, steps):
    """All six strains from corner to corner of a polygon."""
    paths = {}
    for node in (2, 3, 4):
        for dof in (1, 2, 3):
            i, j = sorted((node - 2, dof - 1))
            place, factor = ({(0, 1): 3, (1, 2): 4, (0, 2): 5}[i, j], 0.5) if i != j else (i, 1.0)
            paths[node, dof] = [0.0] + [factor * s[place] for s in strains]
    times = [0]
    for number in steps:
        times.append(times[-1] + number)
    conditions = ["BoundaryCondition 1 loadTimeFunction 1 dofs 3 1 2 3 values 3 0. 0. 0. set 1"]
    functions = ["ConstantFunction 1 f(t) 1."]
    for number, ((node, dof), values) in enumerate(paths.items(), 2):
        conditions.append(f"BoundaryCondition {number} loadTimeFunction {number} dofs 1 {dof} values 1 1. set {node}")
        functions.append(time_function(number, list(zip(times, values))))
    return conditions, functions, times[-1]


CASES = {
    "tension": free_sides([0.004, 0.05], [400, 400]),
    "compression": free_sides([-0.01], [500]),
    "biaxial": free_sides([-0.01], [500], biaxial=True),
    "confined_5": free_sides([-0.03], [600], -5),
    "confined_10": free_sides([-0.03], [600], -10),
    "confined_20": free_sides([-0.04], [800], -20),
    # Cracked, unloaded, crushed: stiffness comes back as the crack closes.
    "reversal": free_sides([0.001, -0.006], [200, 700]),
    "reload": free_sides([-0.004, -0.002, -0.006, 0.0], [200, 100, 200, 300]),
    # Shear with pressure, then everything at once; corners of seeded random directions.
    "sheared": told([(0, 0, 0, 0.003, 0, 0), (-0.002, 0, 0, 0.006, 0, 0.002)], [300, 300]),
    "wandering": told(
        [
            (0.0002, -0.0001, 0.00005, 0.0001, -0.0002, 0.0001),
            (-0.0015, 0.0004, 0.0003, 0.0005, 0.0002, -0.0006),
            (-0.003, 0.0009, 0.0012, -0.0004, 0.0011, 0.0002),
            (-0.001, 0.0012, 0.0010, -0.0014, 0.0005, 0.0008),
        ],
        [200, 300, 300, 300],
    ),
    "pulled_all_round": told([(0.001, 0.0008, 0.0006, 0, 0, 0)], [400]),
    "squeezed_all_round": told([(-0.006, -0.005, -0.004, 0.001, 0, 0)], [400]),
}


# From the values of the card alone.
OF_CARD = {"card_tension": free_sides([0.004, 0.02], [400, 400]), "card_compression": free_sides([-0.01], [500])}


def of_card():
    """OOFEM's material with the fields of *MAT_273, each under the name that OOFEM has for it."""
    lines = CARD.read_text(encoding="utf-8").splitlines()[1:]
    first, second, third = ([float(line[i : i + 10]) for i in range(0, len(line), 10)] for line in lines)
    _, _, e, nu, ecc, qh0, ft, fc = first
    hp, ah, bh, ch, dh, ductility, df = second
    kind, bs, wf, wf1, ft1, _, _, efc = third
    # Bilinear softening through OOFEM's default knee.
    assert kind == bs == 1 and abs(wf1 / wf - 0.15) < 1e-5 and abs(ft1 / ft - 0.3) < 1e-6
    return (
        f"con2dpm 1 d 0 E {e} n {nu} talpha 0. fc {fc} ft {ft} ecc {ecc} kinit {qh0} hp {hp} dilation {df} ahard {ah} "
        f"bhard {bh} chard {ch} dhard {dh} stype 1 wf {wf} asoft {ductility} efc {efc} helem 1.0 yieldtol 1.e-8"
    )


def deck(name, material, conditions, functions, steps):
    count = sum(line.startswith(("Boundary", "Nodal")) for line in conditions)
    nodes = "\n".join(f"node {n} coords 3 {x}. {y}. {z}." for n, (x, y, z) in NODES.items())
    sets = "\n".join(["Set 5 elementranges {1}"] + [f"Set {n} nodes 1 {n}" for n in NODES])
    return f"""{name}.out
one tetrahedron
StaticStructural nsteps {steps} deltat 1.0 rtolf 1e-6 maxiter 4000 stiffmode 1 nmodules 0
domain 3d
OutputManager tstep_all dofman_all element_all
ndofman 4 nelem 1 ncrosssect 1 nmat 1 nbc {count} nltf {len(functions)} nic 0 nset 5
{nodes}
ltrspace 1 nodes 4 1 2 3 4
SimpleCS 1 material 1 set 5
{material}
{os.linesep.join(conditions)}
{os.linesep.join(functions)}
{sets}
"""


def run(name, material, case):
    Path(f"{name}.in").write_text(deck(name, material, *case))
    reader = oofem.OOFEMTXTDataReader(f"{name}.in")
    problem = oofem.InstanciateProblem(reader, oofem.problemMode.processor, 0, None, False)
    problem.checkProblemConsistency()
    problem.solveYourself()
    problem.terminateAnalysis()
    text = Path(f"{name}.out").read_text()
    ours = [0, 1, 2, 5, 3, 4]  # OOFEM's shears are yz, zx, xy
    rows = {}
    for what in ("strains", "stresses"):
        found = [[float(x) for x in line.split()] for line in re.findall(rf"{what}\s+(.*)", text)]
        rows[what] = [[row[i] for i in ours] for row in found]
    return [a + b for a, b in zip(rows["strains"], rows["stresses"])]


def main():
    out = Path(__file__).resolve().parent / "con2dpm"
    out.mkdir(exist_ok=True)
    chosen = sys.argv[1:] or [*CASES, *OF_CARD]
    os.chdir(tempfile.mkdtemp())
    for name in chosen:
        case, material = (CASES[name], MATERIAL) if name in CASES else (OF_CARD[name], of_card())
        rows = run(name, material, case)
        if len(rows) != case[2]:
            raise SystemExit(f"{name}: {len(rows)} of {case[2]} steps")
        head = f"# OOFEM {version('oofem')}: {material}\nexx,eyy,ezz,exy,eyz,ezx,sxx,syy,szz,sxy,syz,szx\n"
        rows = rows[EVERY - 1 :: EVERY]
        (out / f"{name}.csv").write_text(head + "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in rows))


if __name__ == "__main__":
    main()
