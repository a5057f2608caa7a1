"""Nanoseconds that an element and a step of explicit dynamics take, here and in other open programs, on one mesh.

    pip install akantu oofem KratosStructuralMechanicsApplication KratosConstitutiveLawsApplication meshio
    python3 benches/solvers.py           # with the mesocrete wheel installed; enters benches/results/solvers.csv

A cube of 50 mm, 40 % aggregates, a fitted lattice of 3 mm, is compressed along z, on one thread. Every program has a
process of its own, and its steps alone are counted, in processor time: of a long run less those of a short one.
"elastic" is linear; "softening" has the law of each program that is nearest to concrete: damaged plasticity here,
Mazars' damage in Akantu, d+/d- damage in Kratos, CDPM2 in OOFEM. What is not installed is left out. `--quick` takes
elements of 8 mm and a few steps, and enters nothing.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from origin import RESULTS, origin

HEADER = "program,law,elements,steps,ns_per_element_step,times_mesocrete,machine,date,commit"
SPEC = {"fraction": 0.4, "seed": 1, "specimen": {"kind": "cube", "side_mm": 50.0}}
SPEC |= {"grading": {"d_min_mm": 5.0, "d_max_mm": 16.0}, "placement": {"min_gap_mm": 1.0}}
# Elements of the table.
SIZE_MM = 3.0
LAWS = ("elastic", "softening")
# Young's modulus in MPa and density in t/mm3 of mortar and aggregates; Poisson's ratio is 0.2 in both.
PHASES = {"mortar": (26000.0, 2.2e-9), "aggregate": (70000.0, 2.7e-9)}
# What `Mesh.phase` holds in a cell of an aggregate.
AGGREGATE = 2
STRAIN = 0.003
# Below the stable step of the smallest cell; what a step costs does not hang on its length.
STEP_S = 2e-9


def meshed(size):
    """Pack and mesh; the coarse elements of a short run lose most of the aggregates."""
    import mesocrete as mc

    return mc.pack(mc.Spec(**SPEC)).mesh(method="lattice", element_size=size, itz="none", accept_phase_error=size > SIZE_MM)


def mesocrete(mesh, law, steps):
    packed = meshed(float(mesh["size"]))
    options = {"friction": 0.1, "frames": 1, "threads": 1, "duration_s": steps * 4e-7, "time_step_s": 4e-7}
    start = time.process_time()
    packed.solve(law="elastic" if law == "elastic" else "cdp", smoothing="none", **options)
    return start


def akantu(mesh, law, steps):
    import akantu as aka

    write_msh(mesh)
    laws = {"elastic": ("elastic", ""), "softening": ("mazars", "K0 = 1.15e-4\nAt = 0.9\nBt = 3000.\nAc = 1.4\nBc = 1500.\nbeta = 1.06\n")}
    name, more = laws[law]
    blocks = []
    for phase, (modulus, density) in PHASES.items():
        kind, rest = (name, more) if phase == "mortar" else ("elastic", "")
        blocks.append(f"material {kind} [\nname = {phase}\nrho = {density}\nE = {modulus}\nnu = 0.2\n{rest}]\n")
    Path("materials.dat").write_text("".join(blocks))
    aka.parseInput("materials.dat")
    read = aka.Mesh(3)
    read.read("mesh.msh")
    model = aka.SolidMechanicsModel(read)
    selector = aka.MeshDataMaterialSelectorString("physical_names", model)
    getattr(model, "setConstitutiveLawSelector", getattr(model, "setMaterialSelector", None))(selector)
    model.initFull(_analysis_method=aka._explicit_lumped_mass)
    model.setTimeStep(STEP_S)
    z = read.getNodes()[:, 2]
    top, bottom = z > z.max() - 1e-6, z < z.min() + 1e-6
    model.getBlockedDOFs()[top | bottom, 2] = True
    moved = model.getDisplacement()
    start = time.process_time()
    for step in range(steps):
        moved[top, 2] = -STRAIN * 50.0 * (step + 1) / steps
        model.solveStep()
    return start


def kratos(mesh, law, steps):
    import json

    import KratosMultiphysics as K
    from KratosMultiphysics import ConstitutiveLawsApplication as Laws
    from KratosMultiphysics import StructuralMechanicsApplication as Structural
    from KratosMultiphysics.StructuralMechanicsApplication import structural_mechanics_explicit_dynamic_solver as explicit

    K.ParallelUtilities.SetNumThreads(1)
    settings = {
        "solver_type": "dynamic", "time_integration_method": "explicit", "scheme_type": "central_differences",
        "model_part_name": "Structure", "domain_size": 3, "echo_level": 0, "time_step_prediction_level": 0,
        "max_delta_time": 1e-3, "compute_reactions": True, "move_mesh_flag": False, "rotation_dofs": False,
        "volumetric_strain_dofs": False, "model_import_settings": {"input_type": "use_input_model_part"},
        "time_stepping": {"time_step": STEP_S},
    }  # fmt: skip
    model = K.Model()
    part = model.CreateModelPart("Structure")
    part.ProcessInfo[K.DOMAIN_SIZE] = 3
    part.SetBufferSize(2)
    solver = explicit.CreateSolver(model, K.Parameters(json.dumps(settings)))
    solver.AddVariables()
    for number, point in enumerate(mesh["points"], 1):
        part.CreateNewNode(number, *map(float, point))
    properties = [part.CreateNewProperties(number) for number in (1, 2)]
    for (modulus, density), which in zip(PHASES.values(), properties, strict=True):
        which.SetValue(K.YOUNG_MODULUS, modulus)
        which.SetValue(K.POISSON_RATIO, 0.2)
        which.SetValue(K.DENSITY, density)
        which.SetValue(K.CONSTITUTIVE_LAW, Structural.LinearElastic3DLaw())
    if law == "softening":
        soften(K, Laws, properties[0])
    for number, (cell, is_aggregate) in enumerate(zip(mesh["cells"], mesh["aggregate"], strict=True), 1):
        nodes = [int(node) + 1 for node in cell]
        part.CreateNewElement("SmallDisplacementElement3D4N", number, nodes, properties[int(is_aggregate)])
    solver.ImportModelPart()
    solver.PrepareModelPart()
    solver.AddDofs()
    top = []
    for node in part.Nodes:
        if node.Z0 < 1e-6 or node.Z0 > 50.0 - 1e-6:
            node.Fix(K.DISPLACEMENT_Z)
        if node.Z0 > 50.0 - 1e-6:
            top.append(node)
    solver.Initialize()
    now = 0.0
    start = time.process_time()
    for step in range(steps):
        now = solver.AdvanceInTime(now)
        for node in top:
            node.SetSolutionStepValue(K.DISPLACEMENT_Z, 0, -STRAIN * 50.0 * (step + 1) / steps)
        solver.InitializeSolutionStep()
        solver.Predict()
        solver.SolveSolutionStep()
        solver.FinalizeSolutionStep()
    return start


def soften(K, laws, mortar):
    mortar.SetValue(K.CONSTITUTIVE_LAW, laws.SmallStrainDplusDminusDamageModifiedMohrCoulombRankine3D())
    values = {"YIELD_STRESS_TENSION": 3.0, "YIELD_STRESS_COMPRESSION": 40.0, "YIELD_STRESS": 40.0, "FRACTURE_ENERGY": 0.06}
    values |= {"FRACTURE_ENERGY_COMPRESSION": 5.0, "FRICTION_ANGLE": 32.0, "DILATANCY_ANGLE": 30.0}
    for name, value in values.items():
        mortar.SetValue(K.KratosGlobals.GetVariable(name), value)
    mortar.SetValue(laws.SOFTENING_TYPE, 1)
    mortar.SetValue(laws.SOFTENING_TYPE_COMPRESSION, 1)


def oofem(mesh, law, steps):
    import oofem as program

    write_oofem(mesh, law, steps)
    reader = program.OOFEMTXTDataReader("mesh.in")
    problem = program.InstanciateProblem(reader, program.problemMode.processor, 0, None, False)
    problem.checkProblemConsistency()
    start = time.process_time()
    problem.solveYourself()
    return start


def write_oofem(mesh, law, steps):
    points, cells, aggregate = mesh["points"].tolist(), mesh["cells"] + 1, mesh["aggregate"]
    z = mesh["points"][:, 2]
    sets = [np.flatnonzero(~aggregate), np.flatnonzero(aggregate), np.flatnonzero(z < 1e-6), np.flatnonzero(z > 50.0 - 1e-6)]
    softening = "con2dpm {} fc 40. ft 3. wf 0.02 stype 1 hp 0.01 asoft 5. efc 1.e-4 yieldtol 1.e-6"
    common = [f"{n} d {density} E {modulus} n 0.2 talpha 0." for n, (modulus, density) in enumerate(PHASES.values(), 1)]
    lines = [
        "mesh.out", "steps of explicit dynamics", f"NlDEIDynamic nsteps {steps} dumpcoef 0.0 deltaT {STEP_S} nmodules 0", "domain 3d",
        "OutputManager tstep_step 1000000 dofman_output {1}",
        f"ndofman {len(points)} nelem {len(cells)} ncrosssect 2 nmat 2 nbc 2 nltf 2 nic 0 nset 4",
        *(f"node {n} coords 3 {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(points, 1)),
        *(f"ltrspace {n} nodes 4 {' '.join(map(str, cell))}" for n, cell in enumerate(cells.tolist(), 1)),
        "SimpleCS 1 material 1 set 1", "SimpleCS 2 material 2 set 2",
        softening.format(common[0]) if law == "softening" else f"isoLE {common[0]}", f"isoLE {common[1]}",
        "BoundaryCondition 1 loadTimeFunction 1 dofs 1 3 values 1 0. set 3",
        f"BoundaryCondition 2 loadTimeFunction 2 dofs 1 3 values 1 {-STRAIN * 50.0} set 4",
        "ConstantFunction 1 f(t) 1.", f"PiecewiseLinFunction 2 t 2 0. {steps * STEP_S} f(t) 2 0. 1.",
    ]  # fmt: skip
    for number, (kind, members) in enumerate(zip(["elements", "elements", "nodes", "nodes"], sets, strict=True), 1):
        lines.append(f"Set {number} {kind} {len(members)} {' '.join(map(str, members + 1))}")
    Path("mesh.in").write_text("\n".join(lines) + "\n")


def write_msh(mesh):
    import meshio

    tags = np.where(mesh["aggregate"], 2, 1).astype(np.int32)
    named = {"mortar": np.array([1, 3]), "aggregate": np.array([2, 3])}
    data = {"gmsh:physical": [tags], "gmsh:geometrical": [tags]}
    block = [("tetra", mesh["cells"])]
    meshio.write("mesh.msh", meshio.Mesh(mesh["points"], block, cell_data=data, field_data=named), "gmsh22", binary=False)


PROGRAMS = {"mesocrete": mesocrete, "Akantu": akantu, "Kratos": kratos, "OOFEM": oofem}
SECONDS = Path("seconds.txt")
# Long and short runs; the others are slow enough to tell with few steps.
STEPS = {"mesocrete": (1200, 200), "Akantu": (60, 20), "Kratos": (30, 10), "OOFEM": (30, 10)}


def measure(program, law, quick):
    """Processor nanoseconds of an element and step, or None where the program is not installed."""
    steps = (6, 2) if quick and program != "mesocrete" else STEPS[program]
    seconds = []
    for count in steps:
        run = [sys.executable, str(Path(__file__).resolve()), program, law, str(count)]
        done = subprocess.run(run, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"{program}, {law}: {(done.stderr.strip().splitlines() or ['it failed'])[-1]}", file=sys.stderr)
            return None
        seconds.append(float(SECONDS.read_text()))
    return (seconds[0] - seconds[1]) / (steps[0] - steps[1]) * 1e9, steps[0] - steps[1]


def main():
    import os

    quick = "--quick" in sys.argv
    size = 8.0 if quick else SIZE_MM
    mesh = meshed(size)
    aggregate = np.asarray(mesh.phase) == AGGREGATE
    lines = [HEADER]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        np.savez("mesh.npz", points=mesh.points, cells=mesh.cells, aggregate=aggregate, size=size)
        for law in LAWS:
            ours = None
            for program in PROGRAMS:
                measured = measure(program, law, quick)
                if measured is None and program == "mesocrete":
                    sys.exit(1)
                if measured is None:
                    continue
                ns, steps = measured[0] / len(mesh.cells), measured[1]
                ours = ours or ns
                lines.append(f"{program},{law},{len(mesh.cells)},{steps},{ns:.1f},{ns / ours:.1f},{origin()}")
                print(lines[-1], flush=True)
    if not quick:
        (RESULTS / "solvers.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if len(sys.argv) == 4:
        with np.load("mesh.npz") as saved:
            started = PROGRAMS[sys.argv[1]](dict(saved), sys.argv[2], int(sys.argv[3]))
        # Not on stdout, which some of the programs fill.
        SECONDS.write_text(f"{time.process_time() - started}")
    else:
        main()
