"""Types of all options, for editors and type checkers.

Written by make_types.py from `mesocrete schema`; do not edit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from numpy.typing import NDArray
import numpy as np

_Numbers = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]


class NormalAspectRatio(TypedDict, total=False):
    """Normal, redrawn until it lies within the limits."""

    law: Literal["normal"]
    """Name of this form: 'normal'."""
    max: float
    """Upper limit."""
    mean: float
    """Mean."""
    min: float
    """Lower limit."""
    sd: float
    """Standard deviation."""


class UniformAspectRatio(TypedDict, total=False):
    """Uniform within the limits."""

    law: Literal["uniform"]
    """Name of this form: 'uniform'."""
    max: float
    """Upper limit."""
    min: float
    """Lower limit."""


class ConstantAspectRatio(TypedDict, total=False):
    """One value."""

    law: Literal["constant"]
    """Name of this form: 'constant'."""
    value: float
    """The value."""


AspectRatio = NormalAspectRatio | UniformAspectRatio | ConstantAspectRatio


class Cone(TypedDict, total=False):
    """The directions within an angle of one direction, all equally likely."""

    direction: _Numbers
    """Its axis, of any length; a fibre has no front and no back."""
    within_degrees: float
    """Half of its opening, degrees; 0 for parallel fibres, 90 for all directions."""


class FullerCurve(TypedDict, total=False):
    """P(d) = (d / d_max)^n (Fuller and Thompson 1907 with n = 0.5; codes use 0.45 to 0.70)."""

    exponent: float
    """The exponent n."""
    kind: Literal["fuller"]
    """Name of this form: 'fuller'."""


class BolomeyCurve(TypedDict, total=False):
    """P(d) = A + (1 - A) sqrt(d / d_max) (Bolomey 1935)."""

    a: float
    """A, 0.08 for stiff to 0.16 for fluid concrete."""
    kind: Literal["bolomey"]
    """Name of this form: 'bolomey'."""


class SievesCurve(TypedDict, total=False):
    """A sieve analysis; between two sieves P is linear in log d, as such curves are drawn."""

    kind: Literal["sieves"]
    """Name of this form: 'sieves'."""
    passing: _Numbers
    """Share that passes each sieve, 0 to 1."""
    passing_percent: _Numbers
    """Per cent that passes each sieve, 0 to 100, instead of passing."""
    sieves_mm: _Numbers
    """Sieve openings, mm, ascending."""


class StandardCurve(TypedDict, total=False):
    """A curve of a standard; of a band the middle."""

    kind: Literal["standard"]
    """Name of this form: 'standard'."""
    name: Literal["din-1045-2-a8", "din-1045-2-b8", "din-1045-2-c8", "din-1045-2-a16", "din-1045-2-b16", "din-1045-2-c16", "din-1045-2-a32", "din-1045-2-b32", "din-1045-2-c32", "en-12620-4-8", "en-12620-8-16", "en-12620-16-32", "astm-c33-1", "astm-c33-2", "astm-c33-3", "astm-c33-357", "astm-c33-4", "astm-c33-467", "astm-c33-5", "astm-c33-56", "astm-c33-57", "astm-c33-6", "astm-c33-67", "astm-c33-7", "astm-c33-8", "astm-c33-89", "astm-c33-9", "gbt-14685-5-16", "gbt-14685-5-20", "gbt-14685-5-25", "gbt-14685-5-31.5", "gbt-14685-5-40"]
    """Which."""


class SievesFileCurve(TypedDict, total=False):
    """A sieve table (CSV, text; .xlsx in Python) that lies beside the spec, with any heading."""

    blend: dict[str, object]
    """Aggregates in columns, by headings, and the share of each; shares sum to 1 or 100."""
    column: str | int
    """Column of the grading: its heading, or its position from 1."""
    file: str
    """A sieve table (CSV, text; .xlsx in Python) that lies beside the spec, with any heading."""
    kind: Literal["sieves"]
    """Name of this form: 'sieves'."""
    means: Literal["passing", "cumulative-retained", "retained"]
    """Meaning of the column, where neither heading nor numbers say it."""
    sheet: str
    """Sheet of a workbook; Python only."""
    sieve_unit: Literal["mm", "um", "in", "astm-number"]
    """Unit of bare numbers in the column of sieves."""
    unit: Literal["percent", "share", "mass"]
    """Unit of the column's numbers."""


Curve = FullerCurve | BolomeyCurve | SievesCurve | StandardCurve | SievesFileCurve


class Fibres(TypedDict, total=False):
    """Straight fibres, `[fibres]` in a spec."""

    diameter_mm: float
    """Diameter of the cylinder of the same volume and length, mm."""
    fraction: float
    """Their volume over the specimen's, 0 to 1."""
    length_mm: float
    """Length, mm."""
    orientation: Cone | None
    """Directions before placement; all are equally likely where it is absent. Rearrangement rotates the fibres further: the statistics report by how much."""


class Grading(TypedDict, total=False):
    """Sizes of the aggregates: limits, curve and classes."""

    classes_mm: _Numbers
    """Class limits, mm, ascending from `d_min_mm` to `d_max_mm`; left out: every 5 mm or usual sieves."""
    curve: Curve
    """Share of the volume finer than a size, over all sizes."""
    d_max_mm: float
    """Largest aggregate, mm."""
    d_min_mm: float
    """Smallest aggregate, mm."""
    form: Literal["normalised", "raw"]
    """How the part of the curve outside `d_min_mm` to `d_max_mm` is treated."""
    size: Literal["longest-axis", "sieve"]
    """Which length of an aggregate is its size; left out, the longest axis for Fuller's and Bolomey's curves, else the sieve's."""
    size_law: Literal["uniform", "volume-uniform"]
    """How sizes are distributed within a class."""


class GrainTable(TypedDict, total=False):
    """A grain with dents, or a reduced one, as it stands in a spec."""

    faces: Sequence[Sequence[int]]
    """Triangles of the surface, counter-clockwise seen from outside; none where the grain is the hull of its vertices."""
    reduced: Reduction | None
    """What was changed where it is a scan in fewer triangles."""
    vertices: Sequence[_Numbers]
    """Corners, mm."""


class Itz(TypedDict, total=False):
    """Law of the ITZ thickness: uniform between two limits, per aggregate."""

    thickness_mm: _Numbers
    """Lower and upper limit of the thickness, mm. Both 0: the model has no ITZ."""


class OwnPhase(TypedDict, total=False):
    """A phase that some of the aggregates have instead of the phase `aggregate`: an entry of `[[phases]]` in a spec."""

    name: str
    """Name of the phase, which its values have in `[materials]`: lower-case letters, digits and `_`."""
    share: float
    """Volume of its aggregates over that of all aggregates in its classes, above 0 to 1."""
    sizes_mm: _Numbers | None
    """Smallest and largest size of its classes, mm, both of them limits in `grading.classes_mm`; absent, all classes."""


Periodic = Sequence[Literal["x", "y", "z"]]


class Placement(TypedDict, total=False):
    """How aggregates are placed."""

    attempts: int | None
    """Random positions tried per aggregate; absent: up to 50,000."""
    min_gap_mm: float
    """Smallest distance between two aggregates, mm; 0 means: proved apart."""
    strategy: Literal["auto", "take-and-place", "rearrange"]
    """Which strategy places."""
    surplus: float
    """Volume generated beyond the target, as a share of it (the paper's 2 to 3 %)."""
    time_limit_s: float | None
    """Stop after this many seconds with the best packing found."""
    wall_gap_mm: float
    """Smallest distance between an aggregate and the specimen's surface, mm. At periodic faces it is the distance of the aggregates' outermost points, as far as a translation of the whole packing can give it."""


class Reduction(TypedDict, total=False):
    """What changed when a scan was reduced to fewer triangles."""

    distance: float
    """The surfaces lie within this distance of each other, over the length of the grain."""
    scanned_triangles: int
    """Triangles of the scan, or of its hull where that was taken."""
    triangles: int
    """Triangles that are left."""
    volume_change: float
    """Change of the volume, over that of the scan, or of its hull."""


class Shape(TypedDict, total=False):
    """Shape of the aggregates."""

    degree: int
    """Highest degree of the harmonics that counts; 12 by default."""
    elongation: AspectRatio
    """Law of b/a, the intermediate over the longest axis; of no meaning for a library and spheres."""
    flatness: AspectRatio
    """Law of c/b, the shortest over the intermediate axis; of no meaning for a library and spheres."""
    grains: Sequence[Template]
    """The grains of a library."""
    hull: bool
    """Grains of a `library` that are not convex count as their convex hulls."""
    kind: Literal["polyhedron", "rounded", "crushed", "sphere", "ellipsoid", "library", "harmonics"]
    """Which kind of body."""
    library: str
    """A file (STL, PLY, OBJ, OFF, JSON) or folder of grains; lies beside the spec. Each body in a file is a grain."""
    path: str
    """A file (DAT, ANM, TXT) or folder of coefficients n m Re Im, for harmonics; another name of `library`."""
    shells: Sequence[ShellLaw]
    """Shells below the ITZ, from outside; a phase each."""
    tolerance: float
    """Distance within which the surfaces of a `library` are reduced to fewer triangles, as a share of their length, 0 to 0.1; scans of more than 20,000 triangles by 0.005 where it is absent."""
    triangles: int
    """Triangles of the surface that is made of harmonics; 160 by default."""
    vertices: Sequence[int]
    """Fewest and most vertices; of no meaning for a library, spheres and ellipsoids."""


class ShellLaw(TypedDict, total=False):
    """A shell that grains have below their ITZ: an entry of `[[shape.shells]]` in a spec."""

    name: str
    """Name of its phase, as in `[[phases]]`."""
    of: str | None
    """Phase of `[[phases]]` whose grains have it; absent, all aggregates."""
    outward: bool
    """Whether it lies around the stone, as a coating does: the size and the volume that the grading asks for are then the stone's, and the ITZ lies around the coating. Outward shells come first."""
    size_share: _Numbers | None
    """Smallest and largest thickness over the size of its grain, as `grading.size` defines that; instead of a thickness."""
    thickness_mm: _Numbers | None
    """Smallest and largest thickness, mm; every thickness between them is drawn equally often."""
    thickness_over_size_mm: Sequence[_Numbers] | None
    """Rows of size and thickness, mm, of ascending sizes: linear in the size's logarithm between them, constant beyond; instead of a thickness."""
    volume_share: float | None
    """Its volume over that of the grain within its ITZ, above 0 and below 1; instead of a thickness."""


class CubeSpecimen(TypedDict, total=False):
    """A cube from the origin."""

    kind: Literal["cube"]
    """Name of this form: 'cube'."""
    periodic: Periodic
    """The axes along which it repeats itself; it has no walls across them."""
    side_mm: float
    """Side, mm."""


class BoxSpecimen(TypedDict, total=False):
    """A box from the origin."""

    kind: Literal["box"]
    """Name of this form: 'box'."""
    periodic: Periodic
    """The axes along which it repeats itself; it has no walls across them."""
    size_mm: _Numbers
    """Edge lengths along x, y, z, mm."""


class PrismSpecimen(TypedDict, total=False):
    """A box as beams are named: the length along x, the width along y, the depth upwards."""

    depth_mm: float
    """Along z, mm."""
    kind: Literal["prism"]
    """Name of this form: 'prism'."""
    length_mm: float
    """Along x, mm."""
    width_mm: float
    """Along y, mm."""


class CylinderSpecimen(TypedDict, total=False):
    """An upright cylinder: its axis is parallel to z."""

    diameter_mm: float
    """Diameter, mm."""
    height_mm: float
    """Along z, mm."""
    kind: Literal["cylinder"]
    """Name of this form: 'cylinder'."""


class SphereSpecimen(TypedDict, total=False):
    """A sphere."""

    diameter_mm: float
    """Diameter, mm."""
    kind: Literal["sphere"]
    """Name of this form: 'sphere'."""


class NotchedPrismSpecimen(TypedDict, total=False):
    """A prism with a notch sawn into its lower side, across its width, and perhaps one into its upper side."""

    depth_mm: float
    """Along z, the notch's included, mm."""
    kind: Literal["notched-prism"]
    """Name of this form: 'notched-prism'."""
    length_mm: float
    """Along x, mm."""
    notch_at_mm: float
    """Place of both notches along x, mm from the middle of the length."""
    notch_depth_mm: float
    """Depth of the notch, from z = 0 upwards, mm."""
    notch_width_mm: float
    """Width of the notch, along x, mm."""
    upper_notch_depth_mm: float
    """Depth of a second notch above it, from the upper side downwards, mm; 0 for none."""
    width_mm: float
    """Along y, mm."""


class DogboneSpecimen(TypedDict, total=False):
    """A plate that narrows in round arcs to a neck in the middle of its length."""

    kind: Literal["dogbone"]
    """Name of this form: 'dogbone'."""
    length_mm: float
    """Along x, mm."""
    neck_length_mm: float
    """Length of the part that is as narrow as the neck, mm; 0 where the arcs meet in the middle."""
    neck_width_mm: float
    """Narrowest width, mm."""
    radius_mm: float
    """Radius of the arcs, mm; they are polygons within 0.005 mm."""
    thickness_mm: float
    """Along z, mm."""
    width_mm: float
    """Along y, at the ends, mm."""


class PolyhedronSpecimen(TypedDict, total=False):
    """The convex hull of points, moved to the origin."""

    kind: Literal["polyhedron"]
    """Name of this form: 'polyhedron'."""
    vertices_mm: Sequence[_Numbers]
    """Four points or more, mm."""


class MeshSpecimen(TypedDict, total=False):
    """The region that a closed surface of triangles encloses, moved to the origin; in a spec, `file` may name a surface file (STL, PLY, OBJ, OFF) instead."""

    kind: Literal["mesh"]
    """Name of this form: 'mesh'."""
    triangles: Sequence[Sequence[int]]
    """Indices of corners, counter-clockwise seen from outside."""
    vertices_mm: Sequence[_Numbers]
    """Corners, mm."""


class MeshFileSpecimen(TypedDict, total=False):
    """A surface file (STL, PLY, OBJ, OFF) that lies beside the spec."""

    file: str
    """A surface file (STL, PLY, OBJ, OFF) that lies beside the spec."""
    kind: Literal["mesh"]
    """Name of this form: 'mesh'."""
    scale: float
    """Millimetres in a unit of the file: 1000 for metres, 25.4 for inches; 1 by default."""


Specimen = CubeSpecimen | BoxSpecimen | PrismSpecimen | CylinderSpecimen | SphereSpecimen | NotchedPrismSpecimen | DogboneSpecimen | PolyhedronSpecimen | MeshSpecimen | MeshFileSpecimen


Template = Sequence[_Numbers] | GrainTable


class Voids(TypedDict, total=False):
    """Spherical voids, `[voids]` in a spec."""

    diameter_mm: _Numbers | None
    """Smallest and largest diameter, mm; every diameter between them is drawn equally often."""
    fraction: float
    """Their volume over the specimen's, 0 to 1."""
    grading: Grading | None
    """Diameters by a grading of their own, as `[grading]` has the sizes of the aggregates; instead of `diameter_mm`."""


class SpecOptions(TypedDict, total=False):
    """Everything that decides a model, with the paper's specimen as default."""

    fibres: Fibres | None
    """Straight fibres, if any."""
    fraction: float
    """Volume of the aggregates over the specimen's, 0 to 1."""
    grading: Grading
    """Sizes."""
    itz: Itz
    """Interfacial transition zone."""
    mix: dict[str, object]
    """A mix design, `[mix]` in a spec, given instead of `fraction`."""
    phases: Sequence[OwnPhase]
    """Phases that some of the aggregates have instead of the phase `aggregate`."""
    placement: Placement
    """Placement."""
    seed: int
    """Seed of all randomness."""
    shape: Shape
    """Shapes."""
    specimen: Specimen
    """Specimen to fill."""
    voids: Voids | None
    """Spherical voids, if any."""


class MeshOptions(TypedDict, total=False):
    """Options of a mesh, as `mesh`, `Packing.mesh` and a study take them. Leave out the options of other methods."""

    fit: Literal["fitted", "plain"] | None
    """Fit of a lattice to the aggregates' surfaces [default: fitted]"""
    itz: Literal["solid", "cohesive", "smeared", "none"] | None
    """Interfacial transition zone in the mesh [default: solid, or none where the elements are thicker than it; for a test smeared]"""
    joined: Literal["keep", "mortar", "cut"] | None
    """Treatment of aggregates that would share nodes [default: keep; for a test mortar]"""
    narrow_gaps: Literal["keep", "split"] | None
    """Gaps one tetrahedron wide between aggregates [default: keep; for a test of a model split]"""
    order: int | None
    """Order of the elements [default: 1]; 2 puts a node in the middle of every edge of a tetrahedron (C3D10)"""
    slabs: int | None
    """Number of slabs that gmsh fills one by one; absent: as many as its memory needs"""
    subsamples: int | None
    """Sub-samples per voxel and axis, 1 to 8 [default: 1]; with more than 1 each body gets as many voxels as its samples fill"""
    thin_itz: bool | None
    """Let the ITZ of voxels be thinner than one voxel, with holes in it"""
    volumes: Literal["fitted", "exact"] | None
    """Volume of the aggregates in a mesh that follows them [default: exact for grains other than convex polyhedra, and for a test without a solid ITZ; else fitted]"""


class DeckCdpm2Parameters(TypedDict, total=False):
    """Parameters of Grassl et al. 2013, which decks do not have."""

    crushing_strain: float | None
    """Strain of the softening in compression on any width, e_fc; absent, it follows from the crushing energy."""
    dilation: float
    """Lateral over axial plastic strain in uniaxial compression, D_f."""
    hardening_ductility: _Numbers
    """Plastic strain at the peak, over confinement: A_h, B_h, C_h, D_h."""
    hardening_modulus: float
    """Slope of q2 beyond the peak, H_p."""
    initial_hardening: float
    """Start of hardening over the strength, q_h0."""
    softening_ductility: float
    """Ductility of damage in uniaxial compression, A_s."""


class DeckElastic(TypedDict, total=False):
    """Isotropic linear elasticity."""

    density_t_per_mm3: float
    """Density, tonne/mm3."""
    poisson_ratio: float
    """Poisson's ratio."""
    youngs_modulus_mpa: float
    """Young's modulus, MPa."""


class DeckMaterials(TypedDict, total=False):
    """Values of the phases."""

    aggregate: DeckElastic
    """Aggregate cores."""
    aggregate_strength: DeckStone | None
    """Strength of the aggregates in a test; absent, they stay elastic, as they do in decks."""
    cdpm2: DeckCdpm2Parameters
    """Parameters of the solver's law CDPM2 beside the strengths."""
    cohesive_mode_power: float
    """Exponent of Benzeggagh and Kenane's mixed-mode fracture energy of a cohesive ITZ."""
    cohesive_shear_energy_ratio: float
    """Fracture energy of a cohesive ITZ in sliding over that in opening, 1 or more."""
    cohesive_thickness_mm: float
    """Thickness that gives a cohesive ITZ its stiffness E / t, mm."""
    fibre: DeckElastic
    """Fibres, which stay elastic: steel."""
    itz: DeckElastic
    """Interfacial transition zone."""
    itz_strength_ratio: float
    """Strengths and energies of the ITZ over those of the mortar, 0.5 to 0.9 in the literature."""
    meso: DeckMesoscale
    """Crushing and confinement of the solver's law `meso`, which decks do not have."""
    mortar: DeckElastic
    """Mortar."""
    mortar_strength: DeckMortarStrength
    """Strength of the mortar."""
    plasticity: DeckPlasticity
    """Yield surface and flow of the damaged plasticity."""
    scatter: DeckScatter | None
    """Scatter of the strengths of mortar and ITZ over the specimen in a test; absent, each phase has one strength, as in decks."""


class DeckMesoscale(TypedDict, total=False):
    """Parameters of the law `meso` beside the strengths."""

    biaxial_ratio: float
    """Biaxial over uniaxial compressive strength of the mortar."""
    confined_ductility: float
    """Growth of crushing strains with the least confinement over the strength."""
    crushing_length_mm: float
    """Least width of a band of crushing, mm."""
    dilation_angle_deg: float
    """Dilation angle before cohesion is lost, degrees."""
    meridian_bend: float
    """Bend of the meridians: friction falls to half at a least confinement of the strength over this."""
    meridian_ratio: float
    """Ratio of the second invariants on the tensile and the compressive meridian at low pressure, K_c."""


class DeckMortarStrength(TypedDict, total=False):
    """Strength of the mortar. One strength and both energies depend on the law, where they are not given: between the same grains a law that loses more strength to lateral tension needs a stronger mortar for the same concrete. A value that is given holds for every law."""

    compressive_mpa: float | None
    """Compressive strength, MPa; absent: 33 with the law `meso`, 40 with other laws and in decks."""
    crushing_energy_n_per_mm: float | None
    """Energy of crushing beyond the peak, N/mm; absent: 11 with the law `meso`, 5 with other laws and in decks."""
    fracture_energy_n_per_mm: float | None
    """Fracture energy in tension, N/mm; absent: 0.06 with the law `meso`, 0.1 with other laws and in decks."""
    peak_strain: float
    """Strain at the compressive strength."""
    tensile_mpa: float
    """Tensile strength, MPa."""


class DeckPlasticity(TypedDict, total=False):
    """Parameters of `*CONCRETE DAMAGED PLASTICITY`."""

    biaxial_ratio: float
    """Biaxial over uniaxial compressive strength."""
    dilation_angle_deg: float
    """Dilation angle, degrees."""
    eccentricity: float
    """Eccentricity of the flow potential."""
    meridian_ratio: float
    """Ratio of the second invariants on the tensile and the compressive meridian, K_c."""
    viscosity_s: float
    """Viscosity parameter, s (without effect in Abaqus/Explicit)."""


class DeckScatter(TypedDict, total=False):
    """Scatter of the strengths of mortar and ITZ over the specimen, for the law `meso`. One factor multiplies strengths, peak strain and energies of a place, so that openings of cracks keep their law. Stiffness has no scatter."""

    coefficient_of_variation: float
    """Standard deviation of the strengths over their mean; 0 is no scatter."""
    correlation_length_mm: float
    """Distance at which the covariance has fallen to 1/e, mm."""
    covariance: Literal["squared-exponential", "exponential"]
    """Covariance of the Gaussian field over the distance; squared-exponential unless given."""
    distribution: Literal["weibull", "lognormal"]
    """Distribution of the strengths; weibull unless given."""
    phases: Sequence[Literal["mortar", "itz"]]
    """Phases that scatter, by one field; mortar and itz unless given."""
    seed: int
    """Seed of the field, which the packing does not depend on; 1 unless given."""


class DeckStone(TypedDict, total=False):
    """Strength of the aggregates' rock. A grain's kind and its place in the scatter follow from the seed and its number, and from nothing else."""

    compressive_mpa: float
    """Compressive strength, MPa."""
    crushing_energy_n_per_mm: float
    """Energy of crushing beyond the peak, N/mm."""
    fracture_energy_n_per_mm: float
    """Fracture energy in tension, N/mm."""
    kinds: Sequence[DeckStoneKind]
    """Kinds of stone; none are one kind of the strength above."""
    peak_strain: float
    """Strain at the compressive strength."""
    seed: int
    """Seed of the draw."""
    tensile_mpa: float
    """Tensile strength, MPa."""
    weibull_modulus: float | None
    """Weibull modulus of the grains' strengths about their mean; absent, grains of a kind are alike."""


class DeckStoneKind(TypedDict, total=False):
    """A kind of stone."""

    share: float
    """Share of the grains, by number; shares sum to 1."""
    strength_ratio: float
    """Strengths, peak strain and energies over those above."""


class DeckOptions(TypedDict, total=False):
    """Content of a deck besides the mesh."""

    allow_joined: bool
    """Let aggregates that share nodes be crushed or torn: they make an elastic skeleton that never breaks."""
    analysis: Literal["none", "elastic", "striker", "compression", "tension", "splitting", "bending", "four-point", "triaxial", "biaxial", "cyclic", "expansion", "shear", "hopkinson", "hopkinson-splitting", "spall", "drop", "impact"]
    """The analysis the deck runs, or the test; `geometry_only` leaves it out."""
    duration_s: float | None
    """Time of the path, s [default: the test's own, as in `solve`; 0.02 under a striker]"""
    frames: int | None
    """Frames of field output [default: 50]"""
    friction: float | None
    """Friction between plates and specimen [default: the test's own, 0.1 under a striker]"""
    geometry_only: bool
    """Only nodes, elements, sets and surfaces, for *INCLUDE"""
    heading: Sequence[str]
    """Lines for `*HEADING`, e.g. the command and the seed: ASCII, none beginning with `*`; 76 characters of each are kept."""
    impact_speed_mm_per_s: float | None
    """Speed of the striker, mm/s [default: 5000]"""
    lsdyna_law: Literal["cdpm", "rel3", "cscm"]
    """Law of mortar and ITZ in a .k"""
    materials: DeckMaterials
    """Material values."""
    periodic_equations: bool
    """Tie opposite faces of a periodic box by *EQUATION; REF_X, REF_Y and REF_Z take the mean strain"""
    reduced_integration: bool
    """Hexahedra with reduced integration (C3D8R)"""
    strain: float | None
    """Strain at the end of the analysis, a positive number [default: the test's own, 0.001 elastic]"""
    time_increment_s: float | None
    """Time increment that mass scaling keeps, s [default: the test's own, as in `solve`]"""
    with_damage: bool
    """Strength and damage of mortar and ITZ in a deck without an analysis, for steps of your own"""


class SolveBelow(TypedDict, total=False):
    """Strains that phases have without stress below the layer at the surface."""

    aggregate: SolveCourse
    """Linear strain of the aggregates, those of a phase of their own included."""
    fibre: SolveCourse
    """Linear strain of the fibres."""
    itz: SolveCourse | None
    """Linear strain of the ITZ; absent, the mortar's."""
    mortar: SolveCourse
    """Linear strain of the mortar; shrinkage is negative."""


SolveCourse = float | Sequence[_Numbers] | str


class SpeedSolveDrive(TypedDict, total=False):
    """It has this speed."""

    kind: Literal["speed"]
    """Name of this form: 'speed'."""
    speed_m_per_s: SolveSpeed
    """Its speed, m/s."""


class BarSolveDrive(TypedDict, total=False):
    """It is the plane end of a long elastic bar, from which no wave returns."""

    area_mm2: float | None
    """Section of the bar, mm2; absent, it is the area of the side."""
    density_t_per_mm3: float
    """Density of the bar, tonne/mm3."""
    kind: Literal["bar"]
    """Name of this form: 'bar'."""
    poisson_ratio: float | None
    """Poisson's ratio of the bar, by which it disperses [default: 0.29, that of steel]"""
    speed_m_per_s: SolveSpeed
    """Particle speed of the wave that comes along the bar, m/s: half of the speed of a striker of the same bar. Absent, none comes."""
    travel_mm: float | None
    """Way along the bar to the specimen that the wave takes, mm: it arrives later, and dispersed. Absent, it comes as it is."""
    youngs_modulus_mpa: float
    """Young's modulus of the bar, MPa."""


class MassSolveDrive(TypedDict, total=False):
    """It is rigid, has a mass, and strikes the specimen."""

    kind: Literal["mass"]
    """Name of this form: 'mass'."""
    mass_kg: float
    """Its mass, kg."""
    speed_m_per_s: float
    """Its speed when the test begins, m/s."""


SolveDrive = SpeedSolveDrive | BarSolveDrive | MassSolveDrive


class SolveExpansion(TypedDict, total=False):
    """Strains that phases have without stress; they grow before the path begins."""

    aggregate: SolveCourse
    """Linear strain of the aggregates, those of a phase of their own included."""
    below: SolveBelow | None
    """Strains below the layer; absent, there are none."""
    fibre: SolveCourse
    """Linear strain of the fibres."""
    itz: SolveCourse | None
    """Linear strain of the ITZ; absent, the mortar's."""
    layer_mm: float | None
    """Depth of the layer at the surface that has these strains, mm; absent, the whole specimen has them."""
    layer_on: Sequence[Literal["x-min", "x-max", "y-min", "y-max", "z-min", "z-max", "mantle"]]
    """The sides that the layer lies on; the whole surface where none are given."""
    mortar: SolveCourse
    """Linear strain of the mortar; shrinkage is negative."""


class LvdtSolveGauge(TypedDict, total=False):
    """Strain between two planes across an axis, from the mean displacements of the surface's nodes near them."""

    axis: Literal["x", "y", "z"]
    """The axis along which it measures."""
    from_mm: float
    """The lower plane, mm from the lower side."""
    kind: Literal["lvdt"]
    """Name of this form: 'lvdt'."""
    name: str
    """Name of the column."""
    to_mm: float
    """The upper plane, mm from the lower side."""


class SidesSolveGauge(TypedDict, total=False):
    """Strain from the mean displacements of two opposite sides."""

    axis: Literal["x", "y", "z"]
    """The axis along which it measures."""
    kind: Literal["sides"]
    """Name of this form: 'sides'."""
    name: str
    """Name of the column."""


class SideSolveGauge(TypedDict, total=False):
    """Displacement of a side along its axis, mm, positive out of the specimen: its mean by area."""

    kind: Literal["side"]
    """Name of this form: 'side'."""
    name: str
    """Name of the column."""
    on: Literal["x-min", "x-max", "y-min", "y-max", "z-min", "z-max", "mantle"]
    """The side, not the mantle."""


class PartSolveGauge(TypedDict, total=False):
    """Momentum along an axis of the part between two planes across it, N s, e.g. of what a pulse throws off."""

    axis: Literal["x", "y", "z"]
    """The axis."""
    from_mm: float
    """The lower plane, mm from the lower side."""
    kind: Literal["part"]
    """Name of this form: 'part'."""
    name: str
    """Name of the column."""
    to_mm: float
    """The upper plane, mm from the lower side."""


class LateralStrainSolveGauge(TypedDict, total=False):
    """Lateral strain: the mean of both axes across the load, from the sides' nodes in the middle half of the height."""

    kind: Literal["lateral-strain"]
    """Name of this form: 'lateral-strain'."""
    name: str
    """Name of the column."""


class CrackMouthSolveGauge(TypedDict, total=False):
    """Opening of the crack mouth at the lower side of a beam, mm."""

    kind: Literal["crack-mouth"]
    """Name of this form: 'crack-mouth'."""
    name: str
    """Name of the column."""
    over_mm: float | None
    """Gauge length along the lower side, mm; absent, it is the notch's, or the depth of a beam without one."""


SolveGauge = LvdtSolveGauge | SidesSolveGauge | SideSolveGauge | PartSolveGauge | LateralStrainSolveGauge | CrackMouthSolveGauge


class SolveInterface(TypedDict, total=False):
    """Properties of cohesive faces beside `[materials]`, which a deck cannot have."""

    friction: float
    """Coulomb's coefficient in a crack."""


SolveSpeed = float | Sequence[_Numbers] | str


class SolveStrip(TypedDict, total=False):
    """A strip across a side: a roller, or the strip of a splitting test."""

    at_mm: float
    """Its centre, mm from the middle of the specimen."""
    axis: Literal["x", "y", "z"]
    """Axis along which its width and its place are measured."""
    length_mm: float | None
    """Its length across that axis, mm, from its middle on the middle of the side; absent, it crosses the whole side."""
    width_mm: float
    """Its width, mm; at least one and a half elements are taken."""


class SolveSupportSpec(TypedDict, total=False):
    """A support or a load of a specimen."""

    drive: SolveDrive | None
    """What moves a plate in real time; the test has no path then: `{ kind = 'speed' }`, `'bar'` or `'mass'`."""
    friction: float
    """Coulomb's coefficient of a plate."""
    moves: float
    """Its way along the axis of its side for each mm of the test's path; 0 keeps it at rest."""
    name: str
    """Its name, which its column of `curve.csv` has."""
    on: Literal["x-min", "x-max", "y-min", "y-max", "z-min", "z-max", "mantle"]
    """The side that it acts on."""
    pressure_mpa: float
    """Pressure, or the mean stress that a servo gives a plate before the path begins, MPa. It grows to this value before the path begins."""
    rule: Literal["plate", "glued", "pressure"]
    """Plate, glued or pressure."""
    stress_ratio: float | None
    """Mean stress that a servo gives a plate over the stress of the test."""
    strip: SolveStrip | None
    """The part of the side; absent, it is the whole side."""


class SolveTurn(TypedDict, total=False):
    """A place at which the path turns."""

    at: float
    """The value at which it turns."""
    of: Literal["strain", "stress", "opening"]
    """The quantity of the value."""


class SolveOptions(TypedDict, total=False):
    """A test of a specimen. Whatever is absent takes its default from the mesh and the kind of test."""

    control: Literal["servo", "crack-mouth", "lateral-strain", "steady"] | None
    """Plates that slow down while the specimen breaks, follow the crack mouth or the lateral strain, or keep their speed as in a deck [default: servo; steady in real time]"""
    duration_s: float | None
    """Time of the test at the plates' full speed, s; short ones are not quasi-static [default: by the height and the strain]"""
    expansion: SolveExpansion | None
    """Strains of the phases that have no stress; they grow before the path begins. An expansion test without them has 1e-4 in the aggregates."""
    frames: int
    """Frames of all fields, evenly over the strain (where the path turns, the time), 0 for none"""
    friction: float | None
    """Friction between plates and specimen; in tension the plates are glued on [default: 0.1; 0.5 in splitting]"""
    gauges: Sequence[SolveGauge]
    """Gauges, each a column of the curve; those of the named test where none are given."""
    history: str | None
    """A CSV file with turns instead, beside the TEST.toml: a column named strain, stress_mpa or opening_mm, a row for each turn."""
    hourglass: float
    """Stiffness of hourglass modes over the true one, 0 to 1 (hexahedra of mortar and ITZ)."""
    interface: SolveInterface
    """Cohesive faces."""
    law: Literal["meso", "cdp", "cdpm2", "elastic"]
    """The law of mortar and ITZ: meso is that of mortar between grains, cdp the twin of a deck, cdpm2 for comparison"""
    mass_kg: float | None
    """Mass that falls, kg [default: 1]"""
    pressure_mpa: float | None
    """Lateral pressure of a triaxial test, MPa, negative in tension; 5 where absent. Of a test between bars: on the mantle, or on the ends of a split specimen; none where absent."""
    pulse_s: float | None
    """Length of the pulse of a Hopkinson or spall test at half of its height, s [default: 1e-4; spall 4e-5]"""
    ramp: float
    """Share of the time in which the plates gain their speed."""
    rate_effect: bool
    """Let the strengths of mortar and ITZ grow with the rate of strain, by the first branch of fib Model Code 2010, 5.1.11 (in real time, with the law meso)."""
    rise_s: float | None
    """Time in which the pulse or the plate's speed rises, s: a pulse shaper's [default: 2e-5; spall 5e-6, impact 1e-5]"""
    rows: int
    """Rows of the curve, at most, and as densely where the servo adds steps."""
    smoothing: Literal["none", "edges"] | None
    """Smooth the strains of tetrahedra, so that peaks hardly depend on their size [default: edges; none for voxels]"""
    span_mm: float | None
    """Distance of a beam's rollers, mm."""
    speed_m_per_s: float | None
    """Speed of the striker, the falling mass or the plate of a test in real time, m/s [default: 8; spall 1, drop 3]"""
    starts_moving: bool
    """Let the specimen begin with the speeds of a uniform strain between two opposite plates that have a speed from the first moment, so that they send no wave."""
    strain: float | None
    """Strain at the end [default: by the test; 0.005 in compression, 0.0005 in tension]"""
    stress_ratio: float | None
    """Lateral over axial stress of a biaxial test; 1 where absent."""
    strip_mm: float | None
    """Width of the strips of a splitting test, or of a beam's rollers, mm."""
    supports: Sequence[SolveSupportSpec]
    """Supports and loads; those of the named test where none are given."""
    time_step_s: float | None
    """Time step that mass scaling keeps, s [default: by the element size]"""
    turns: Sequence[SolveTurn]
    """Places at which the path turns; straight on to `strain` where none are given."""


EffectiveAxes = str


EffectiveFramePick = str | float


EffectivePhasesGiven = str | dict[str, object]


class EffectiveOptions(TypedDict, total=False):
    """Effective diffusivity, conductivity, permeability and stiffness, each with its error."""

    axes: EffectiveAxes
    """Axes of the gradient; each takes a solution. Stiffness always has all"""
    boundary: Literal["fixed", "uniform-gradient", "uniform-flux"]
    """Conditions at walls: fixed, given potentials at the ends of the gradient and insulated sides; uniform-gradient, an upper estimate, or uniform-flux, a lower one, in tetrahedra"""
    crack_conductivity: float | None
    """Conductivity of what fills the cracks of a frame, W/(m K) [default: 0.6, of water]"""
    crack_diffusivity: float | None
    """Diffusivity of what fills the cracks of a frame, in the unit of the phases [default: 200 times the mortar's, as of chloride in water]"""
    crack_roughness: float | None
    """Permeability of the cracks of a frame over that of smooth ones, whose opening w gives w^2/12 [default: 1]"""
    eigenstrain: dict[str, object]
    """Strains without stress of the phases, which expand or shrink the specimen, as in mortar=-4e-4,itz=-4e-4"""
    frame: EffectiveFramePick | None
    """Frame of a test: peak, last, all, its number from 1, or the strain that it is nearest to [default: peak]"""
    method: Literal["voxel", "lattice", "conforming"]
    """Division of a model: voxel, or lattice, tetrahedra whose faces follow the aggregates"""
    no_fields: bool
    """Write no fields"""
    periodic: EffectiveAxes | None
    """Axes along which a label volume repeats itself; without, it has walls"""
    phases: EffectivePhasesGiven | None
    """Values of the phases: a TOML file with the tables [diffusivity], [conductivity] and [permeability], each with mortar, aggregate, itz, void, fibre [default: diffusivity 1, 0, 1, 0, 0; conductivity 1.5, 3, 1.5, 0.025, 50 W/(m K); permeability 1e-11, 0, 1e-11, 0, 0 mm2], and with tables such as [stiffness.mortar], each with youngs_modulus_mpa, poisson_ratio, eigenstrain. A label volume takes labels as keys, too, as in 0 = 1.0"""
    tolerance: float | None
    """Error of the equations, over the result, beside that of the voxels [default: 1e-9; of stiffness 1e-12]"""
    what: Literal["diffusivity", "conductivity", "stiffness", "permeability", "all"]
    """Property"""


class FitOptions(TypedDict, total=False):
    """Options of a fit, beside the curve, the spec and the materials to start from."""

    accept_phase_error: bool
    """Accept meshes that show a phase badly, as `solve` does"""
    friction: float | None
    """Friction between plates and specimen"""
    law: Literal["meso", "cdp", "cdpm2", "elastic"] | None
    """The law of mortar and ITZ [default: that of solve]"""
    seeds: int
    """Number of packings, of successive seeds from the spec's on; their scatter is the uncertainty"""
    steps: int
    """Most steps after the first five points; each tests every packing once"""
    strain: float | None
    """Mean axial strain at the end [default: 1.15 times the last one of the curve]"""


class StatisticsOptions(TypedDict, total=False):
    """How much is sampled, and how finely it is resolved."""

    lag_mm: float
    """Step between two lags of the correlation functions, mm."""
    lags: int
    """Number of lags, from 0; those that no line of the specimen has are left out, as are those beyond 10,000."""
    layer_mm: float
    """Width of a layer of the wall effect, mm; at least a thousandth of the specimen."""
    lines: int
    """Random lines for the correlation functions."""
    points: int
    """Random points for the wall effect."""
    seed: int
    """Seed of the samples."""
    whole: bool
    """Whether all aggregates with dents are measured, and all lines looked at, however many triangles these have."""


class NamedTest(SolveOptions, total=False):
    """A test and its name, as `Test` returns it."""

    test: Literal["compression", "tension", "splitting", "bending", "four-point", "triaxial", "biaxial", "cyclic", "expansion", "shear", "hopkinson", "hopkinson-splitting", "spall", "drop", "impact"]
    """The named test."""


class MeshStep(MeshOptions, DeckOptions, total=False):
    """A mesh and its deck in a study: keywords of `Packing.mesh` and `Mesh.write`, and the files of the mesh."""

    output: str | Sequence[str]
    """Names of the files in the folder of a case; required."""
    method: Literal["voxel", "lattice", "conforming"]
    """Method of meshing."""
    element_size: float | Literal["auto"]
    """Edge length of the elements, mm."""
    accept_phase_error: bool
    """Whether a phase may be more than 10 % off its exact volume."""
    strict: bool
    """Whether a phase that is more than 1 % off fails the case."""
    compress: bool
    """Whether the data of a .vtu are compressed."""


class SolveStep(NamedTest, MeshOptions, total=False):
    """A test in a study: keywords of `Mesh.solve` and `Packing.mesh`."""

    method: Literal["voxel", "lattice", "conforming"]
    """Method of meshing."""
    element_size: float | Literal["auto"]
    """Edge length of the elements, mm."""
    accept_phase_error: bool
    """Whether a phase may be more than 10 % off its exact volume."""
    materials: DeckMaterials
    """Material values."""
    brush: bool
    """Plates of brushes or teflon: a friction of 0.005."""
    device: str
    """What takes the steps: "cpu", "gpu", "cuda:N" or "opencl:N"."""


class EffectiveStep(EffectiveOptions, total=False):
    """Effective properties in a study: keywords of `Packing.effective`."""

    element_size: float
    """Edge length of the tetrahedra, mm."""
    voxel_size: float
    """Edge of a voxel, mm."""
