"""Types of all dicts that the package returns, for editors and type checkers.

Written by make_results.py from the Rust structs; do not edit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import NotRequired

# `class` is no name of Python's: the table and a few more have their keys as texts.
Table = TypedDict(
    "Table",
    {
        "id": NDArray[np.int64],
        "class": NDArray[np.int64],
        "phase": NDArray[np.str_],
        "size_mm": NDArray[np.float64],
        "sieve_size_mm": NDArray[np.float64],
        "volume_mm3": NDArray[np.float64],
        "area_mm2": NDArray[np.float64],
        "sphericity": NDArray[np.float64],
        "centroid_x_mm": NDArray[np.float64],
        "centroid_y_mm": NDArray[np.float64],
        "centroid_z_mm": NDArray[np.float64],
        "itz_thickness_mm": NDArray[np.float64],
        "vertices": NDArray[np.int64],
        "faces": NDArray[np.int64],
    },
)
"""Every aggregate, void and fibre as a row."""


class Reduction(TypedDict):
    """What changed when a scan was reduced to fewer triangles."""

    scanned_triangles: int
    """Triangles of the scan, or of its hull where that was taken."""
    triangles: int
    """Triangles that are left."""
    distance: float
    """The surfaces lie within this distance of each other, over the length of the grain."""
    volume_change: float
    """Change of the volume, over that of the scan, or of its hull."""


class SpecimenReport(TypedDict):
    """Kind and volume of the specimen."""

    kind: str
    """As in the spec."""
    volume_mm3: float
    """Volume of the specimen, mm3."""
    origin_mm: NotRequired[list[float] | None]
    """Lowest corner of the vertices of the spec, mm, where it is not the origin. The packing has its origin there: its coordinates plus these are those of the file."""


class ClassReport(TypedDict):
    """Asked and reached volume of one class, over the specimen's volume."""

    d_min_mm: float
    """Lower limit, mm."""
    d_max_mm: float
    """Upper limit, mm."""
    target_fraction: float
    """Fraction of the specimen asked for."""
    fraction: float
    """Fraction of the specimen reached."""
    aggregates: int
    """Number of aggregates."""


class PhaseReport(TypedDict):
    """Asked and reached volume of a further phase, over the specimen's volume."""

    phase: str
    """Voids or fibres."""
    target_fraction: float
    """Fraction of the specimen asked for."""
    fraction: float
    """Fraction of the specimen reached."""
    volume_mm3: float
    """Volume of the bodies, mm3."""
    bodies: int
    """Number of bodies."""
    classes: NotRequired[list[ClassReport]]
    """Per class of diameters, from the finest, where voids have a grading of their own; `aggregates` counts the voids."""


class OwnPhaseReport(TypedDict):
    """Asked and reached volume of a phase of the aggregates' own, ITZ shells included, over the specimen's volume."""

    phase: str
    """Name in the spec."""
    target_fraction: float
    """Fraction of the specimen asked for."""
    fraction: float
    """Fraction of the specimen reached."""
    volume_mm3: float
    """Volume of the bodies, mm3."""
    aggregates: int
    """Number of aggregates."""


class ShellReport(TypedDict):
    """Volume of the shells of a phase, over the specimen's volume."""

    phase: str
    """Name of the phase in the spec."""
    fraction: float
    """Fraction of the specimen that the shells take."""
    volume_mm3: float
    """Volume of the shells, mm3."""
    aggregates: int
    """Number of aggregates that have one."""


class Work(TypedDict):
    """Numbers of candidates or pairs that each stage saw; a pair that a stage decides goes no further."""

    candidates: int
    """Candidate positions tried."""
    pairs_broad: int
    """Pairs the broad phase named."""
    pairs_sphere: int
    """Pairs left after the bounding spheres."""
    pairs_axis: int
    """Pairs left after the ellipsoid axis."""
    gjk_calls: int
    """Pairs put to GJK."""
    exact_calls: int
    """Pairs put to exact arithmetic."""
    sweeps: int
    """Sweeps of the rearrangement."""


class Seconds(TypedDict):
    """Wall-clock seconds by stage. The core reads no clock: its callers fill these in."""

    total: float
    """Whole run."""
    take: float
    """Generating the grains."""
    place: float
    """Placing the grains."""
    write: float
    """Writing files."""


class ReducedGrain(Reduction):
    """A grain of the library that is a scan in fewer triangles."""

    grain: int
    """Position in the library, from 0."""


class CoreReport(TypedDict):
    """A drilled core in a label volume."""

    outside: list[int]
    """Labels outside of it."""
    diameter_mm: float
    """Diameter of the cylinder of its volume, mm."""
    voxels: int
    """Voxels of this cylinder, of which the shares below are."""
    off_fraction: float
    """Voxels that are beyond the cylinder, or missing within, over those of the core."""
    pores_fraction: float
    """Share of the cylinder that has a label of the outside, such as pores; it is mortar."""


class LabelReport(TypedDict):
    """A label volume whose grains the aggregates are."""

    voxels: list[int]
    """Voxels along x, y, z."""
    voxel_size_mm: list[float]
    """Edges of a voxel along x, y, z, mm."""
    fraction: float
    """Share of the voxels that the aggregates had, hollows included, to compare with their fraction."""
    farthest_mm: float
    """Largest distance of a face between a grain's voxels and others to its surface, mm; some 500 faces a grain are measured."""
    separated_pairs: int
    """Pairs of grains that share a face in the labels, and are apart in the model."""
    dropped: int
    """Grains dropped as too small, or too thin for a surface."""
    dropped_fraction: float
    """Share of the voxels that they had."""
    lost_fraction: float
    """Share of the specimen that was grains in the labels and is mortar in the model: dropped, or lost by gaps and smoothing."""
    core: NotRequired[CoreReport | None]
    """The drilled core that the specimen is; absent where it is the whole volume."""
    filled: int
    """Grains with hollows, mortar that one grain encloses, which were filled."""
    filled_fraction: float
    """Share of the voxels that the hollows had."""
    labels: list[int]
    """Label of every aggregate, by id."""


class Report(TypedDict):
    """The figures of one run: the keys of `--summary-json`."""

    version: str
    """Version of mesocrete."""
    seed: int
    """Seed of the run."""
    target_fraction: float
    """Asked volume fraction of the aggregates, 0 to 1."""
    fraction: float
    """Reached volume fraction."""
    coated_fraction: NotRequired[float | None]
    """Fraction of the aggregates with their outward shells and the ITZ around them, where the spec asks for some; all other fractions are then of stones."""
    aggregates: int
    """Aggregates placed."""
    discarded: int
    """Aggregates taken but not placed."""
    specimen: SpecimenReport
    """The specimen."""
    grading: str
    """The curve behind the classes, e.g. `fuller, normalised, n = 0.5`."""
    strategy: str
    """The strategy that placed."""
    classes: list[ClassReport]
    """Per size class, from the finest."""
    phases: NotRequired[list[PhaseReport]]
    """Voids and fibres, where the spec asks for some."""
    own_phases: NotRequired[list[OwnPhaseReport]]
    """Aggregates of a phase of their own, where the spec asks for some; they count among all aggregates above, too."""
    shells: NotRequired[list[ShellReport]]
    """Shells of the aggregates below their ITZ, where the spec asks for some."""
    itz_limited: list[int]
    """Aggregates whose drawn ITZ was thinner than asked by the documented limit, by id."""
    itz_thin: NotRequired[list[int]]
    """Aggregates with dents that have parts thinner than two of their ITZ, by id: nothing of these parts is inside the ITZ."""
    reduced: NotRequired[list[ReducedGrain]]
    """The scans among the grains of the library that were reduced."""
    labels: NotRequired[LabelReport | None]
    """The label volume that the aggregates come from, where they do."""
    stop_reason: str
    """Why the placement ended."""
    stop_detail: str
    """The reason for the stop in a sentence: which class or fraction fell short, and by how much."""
    work: Work
    """Counters of each stage."""


class Distribution(TypedDict):
    """Mean, spread and quantiles of a sample; a quantile between two values is between them as it is between their ranks."""

    mean: float
    """Mean of the values."""
    sd: float
    """Standard deviation (of the sample, over n)."""
    min: float
    """Smallest value."""
    p10: float
    """A tenth is less."""
    median: float
    """Median: half of the values are less."""
    p90: float
    """Nine tenths are less."""
    max: float
    """Largest value."""


class Zingg(TypedDict):
    """Zingg's four classes, divided at b / a = 2/3 and c / b = 2/3 (Zingg 1935)."""

    equant: int
    """Both ratios above 2/3."""
    disc: int
    """Flat, not elongated: c / b at most 2/3."""
    rod: int
    """Elongated, not flat: b / a at most 2/3."""
    blade: int
    """Both at most 2/3."""


class Shapes(TypedDict):
    """Shape of all aggregates, each counted once."""

    length_mm: Distribution | None
    """Longest extent a, mm."""
    elongation: Distribution | None
    """Elongation b / a."""
    flatness: Distribution | None
    """Flatness c / b."""
    wadell_sphericity: Distribution | None
    """Wadell's sphericity: surface of the ball of the same volume over the surface (Wadell 1932)."""
    krumbein_sphericity: Distribution | None
    """Krumbein's intercept sphericity, the cube root of b c / a^2 (Krumbein 1941)."""
    convexity: Distribution | None
    """Convexity: volume over that of the convex hull."""
    sieve_size_mm: Distribution | None
    """Width of the smallest square hole passed, mm."""
    zingg: Zingg
    """Numbers by Zingg's classes."""


class Orientation(TypedDict):
    """Directions of the longest axes."""

    tensor: list[list[float]]
    """Mean of a a^T over the unit vectors a along the longest axes: a third of the identity where there is no order."""
    eigenvalues: list[float]
    """Eigenvalues of the orientation tensor, ascending; they sum to 1."""


class WallEffect(TypedDict):
    """Aggregate fraction by layers parallel to the surface."""

    depth_mm: list[float]
    """Middle of the layer below the specimen's surface, mm."""
    fraction: list[float]
    """Share of the layer's sampled points that lie in an aggregate."""
    points: list[int]
    """Sampled points in the layer: the fraction's standard error is sqrt(f (1 - f) / points)."""


class Correlation(TypedDict):
    """The correlation functions at equidistant lags."""

    lag_mm: list[float]
    """Lags r, mm."""
    two_point: list[float]
    """S2(r), from pairs of points that both lie in the specimen."""
    lineal_path: list[float]
    """Lineal path L(r)."""
    slope_per_mm: float
    """Slope of the pairs' measure at r = 0, from the number of chord ends, 1/mm: minus a quarter of the specific surface."""
    mean_chord_mm: float
    """Mean length of the chords, mm."""
    lines: int
    """Random lines looked at."""


class PhaseFigures(TypedDict):
    """The figures of one phase beside the aggregates."""

    phase: str
    """Voids or fibres."""
    bodies: int
    """Number of bodies."""
    volume_mm3: float
    """Volume of the phase's bodies, mm3."""
    fraction: float
    """Volume of the phase's bodies over the specimen's."""
    specific_surface_per_mm: float
    """Surface of the phase's bodies over the specimen's volume, 1/mm."""
    orientation: NotRequired[Orientation | None]
    """Directions of the longest axes; absent for voids, which have none."""


class Sampled(TypedDict):
    """How many of a packing's aggregates were measured, where these have many triangles. They are spread evenly over all sizes."""

    aggregates: int
    """Aggregates of the packing."""
    shapes: int
    """Aggregates whose shapes were measured."""
    nearest: int
    """Aggregates that looked for their nearest neighbour."""
    lines_asked: int
    """Random lines that were asked for; those that were looked at stand with the correlation functions."""


class Statistics(TypedDict):
    """The figures of one packing."""

    fraction: float
    """Volume of the aggregates over the specimen's."""
    specific_surface_per_mm: float
    """Surface of the aggregates over the specimen's volume, 1/mm."""
    classes: list[ClassReport]
    """Asked and reached volume, and number, by size class."""
    shapes: Shapes
    """Shapes of the aggregates."""
    orientation: Orientation
    """Directions of the longest axes."""
    wall_effect: WallEffect
    """Fraction against depth."""
    nearest_distance_mm: Distribution | None
    """Distance from each aggregate to the nearest other one, mm; absent for fewer than two. In a periodic specimen images count as others, an aggregate's own among them."""
    correlation: Correlation
    """Two-point correlation and lineal path."""
    phases: NotRequired[list[PhaseFigures]]
    """Voids and fibres, where there are some; all other figures are of the aggregates alone."""
    sampled: NotRequired[Sampled | None]
    """How many aggregates were measured; absent where it is all of them, as without dents of many triangles."""


class InterfaceDistance(TypedDict):
    """How far the nodes where aggregates meet other materials lie from the exact surfaces; in voxels and plain lattices it is the staircase that is measured. Nodes that cohesive elements separate are one; middles of edges are left out."""

    nodes: int
    """Nodes where an aggregate meets something else."""
    off: int
    """Interface nodes that lie on the surface of no aggregate that meets there, nor on a flat side of the specimen, by more than 1e-9 of the specimen."""
    rms_mm: float
    """Root mean square of all nodes' distances, mm: each to the nearest of these surfaces."""
    max_mm: float
    """The largest of these distances, mm."""
    joined: int
    """Nodes that close a gap: several aggregates meet there, or one and a flat side of the specimen that does not cut it."""
    joined_rms_mm: float
    """Root mean square of the gaps at these nodes, mm: from the node to the farthest of the aggregates that meet there."""
    joined_max_mm: float
    """The largest of these distances, mm."""


class PhaseVolumes(TypedDict):
    """Volume of every phase, mm3."""

    aggregate: float
    """Aggregate cores, those of a phase of their own included."""
    itz: float
    """Shells."""
    mortar: float
    """Everything else, but for voids."""
    fibre: NotRequired[float]
    """Fibres."""


class QualityReport(TypedDict):
    """The worst of all cells, with a histogram, and how much of each phase is there. Cells are indices; decks count from 1."""

    cells: int
    """Number of cells."""
    min_dihedral_deg: list[float]
    """Smallest dihedral angle, degrees, and the cell's index."""
    max_dihedral_deg: list[float]
    """Largest dihedral angle, degrees, and the cell's index."""
    min_radius_ratio: list[float]
    """Smallest radius ratio and the cell's index."""
    shortest_altitude_mm: list[float]
    """Shortest altitude, mm, and the cell's index."""
    dihedral_histogram: list[int]
    """Cells by smallest dihedral angle: below 1, 2, 5, 8, 10, 15, 30 degrees and the rest."""
    bad_cells: list[int]
    """The cells with a dihedral angle below 8 degrees."""
    inverted: int
    """Cells with no positive volume."""
    stable_time_step_s: float
    """Stable time step of explicit dynamics, s: 1 / (c sqrt(sum |grad N|^2)) of the worst cell, c the dilatational wave speed."""
    cohesive_time_step_s: float | None
    """Shortest stable time step of cohesive elements, by their stiffness and mass per area; `None` where there are none."""
    volumes_mm3: PhaseVolumes
    """Volume of every phase in the mesh, mm3."""
    exact_volumes_mm3: PhaseVolumes | None
    """Volumes of the phases from the polyhedra themselves, with the shells of a solid ITZ where the mesh has one; `None` where a core has no trustworthy volume."""
    interface_distance: InterfaceDistance
    """How near the interfaces lie to the aggregates' surfaces."""


class PhaseScaling(TypedDict):
    """One phase's share of it."""

    phase: str
    """Name of the phase's element set."""
    elements: int
    """Number of elements."""
    scaled: float
    """Share of them whose own step is shorter, 0 to 1."""
    factor: float
    """Mass of the elements with the added mass, over their own."""
    shortest_step_s: float
    """Shortest step of its elements, s."""
    mass_t: float
    """Their mass before scaling, tonne."""


class MassScaling(TypedDict):
    """The mass that a time step costs."""

    time_step_s: float
    """The step, s."""
    factor: float
    """Mass of all elements with the added mass, over their own."""
    phases: list[PhaseScaling]
    """The phases that the mesh has; cohesive elements are the ITZ."""


class CheckResult(TypedDict):
    """Scope and findings of a check. Where a finding speaks of an aggregate, voids and fibres are included: their ids follow those of the aggregates."""

    sound: bool
    """True where nothing was found."""
    aggregates: int
    """Number of aggregates checked."""
    pairs_tested: int
    """Pairs whose boxes come within the asked gap of each other: those were put to the exact test."""
    fraction: float
    """Volume of the polyhedra over the specimen's."""
    findings: list[dict[str, str | int | float]]
    """Everything that is not as promised; empty for a sound model."""
    not_checked: list[str]
    """Promises that were not checked, in words."""


class PropertyBounds(TypedDict):
    """Bounds of Voigt, Reuss, and Hashin and Shtrikman (J. Appl. Phys. 33, 1962, 3125).  Bounds of Hashin and Shtrikman hold for an isotropic mixture; one direction of a small specimen may cross them."""

    reuss: float
    """Phases in series."""
    hashin_shtrikman_lower: float
    """Lower bound of an isotropic mixture."""
    hashin_shtrikman_upper: float
    """Upper bound of an isotropic mixture."""
    voigt: float
    """Phases in parallel."""


class Resolution(TypedDict):
    """The division of a specimen into voxels or tetrahedra, and the solutions on it."""

    boundary: list[str]
    """Conditions at the ends of x, y, z: `periodic`; at walls `fixed` along the gradient and insulated across it, or for stiffness `uniform-strain`."""
    voxels: NotRequired[list[int] | None]
    """Voxels along x, y, z."""
    voxel_size_mm: NotRequired[list[float] | None]
    """Edges of a voxel, mm."""
    elements: NotRequired[int | None]
    """Number of tetrahedra."""
    element_size_mm: NotRequired[float | None]
    """Edge of the tetrahedra, mm."""
    iterations: list[int]
    """Iterations of each solution on the fine voxels or tetrahedra."""
    solver_error: float
    """Largest error of the equations, over the result."""


class At(TypedDict):
    """A moment of a test, if a result belongs to one."""

    frame: NotRequired[int | None]
    """Number of the frame, from 1; 0 is the end of a test in memory."""
    strain: NotRequired[float | None]
    """Mean axial strain, positive in the test's sense."""
    stress_mpa: NotRequired[float | None]
    """Stress, positive in the test's sense, MPa."""


class PhaseShare(TypedDict):
    """A phase in the result."""

    name: str
    """Name of the phase, or its label."""
    value: float
    """Its value."""
    volume_fraction: float
    """Its exact volume over the specimen's."""


class Effective(Resolution, At):
    """An effective property."""

    what: str
    """Property."""
    tensor: list[list[float | None]]
    """The tensor: extrapolated from three sizes of voxels or tetrahedra where they show an order, and within Reuss and Voigt; of a label volume, the middle of its bounds."""
    error: list[list[float | None]]
    """Error of each entry, which contains the exact value: by the changes from size to size, or by bounds of a label volume."""
    fine: list[list[float | None]]
    """The tensor on the voxels or tetrahedra."""
    coarse: list[list[float | None]]
    """The tensor on those of twice the size; nothing of a label volume."""
    bounds: PropertyBounds
    """Bounds on an isotropic mixture of the phases."""
    phases: list[PhaseShare]
    """Phases with their volumes."""
    warnings: list[str]
    """What a reader should know."""


class ElasticShare(TypedDict):
    """A phase in the result."""

    name: str
    """Name of the phase, or its label."""
    youngs_modulus_mpa: float
    """Young's modulus, MPa."""
    poisson_ratio: float
    """Poisson's ratio."""
    eigenstrain: float
    """Strain without stress."""
    volume_fraction: float
    """Exact volume over the specimen's."""


class ElasticBounds(TypedDict):
    """Bounds of an isotropic mixture, MPa."""

    bulk_modulus_mpa: PropertyBounds
    """Bounds of the bulk modulus."""
    shear_modulus_mpa: PropertyBounds
    """Bounds of the shear modulus."""


class Isotropic(TypedDict):
    """Constants of the isotropic material that is nearest to a stiffness: mean over all directions."""

    bulk_modulus_mpa: float
    """Bulk modulus, MPa."""
    shear_modulus_mpa: float
    """Shear modulus, MPa."""
    youngs_modulus_mpa: float
    """Young's modulus, MPa."""
    poisson_ratio: float
    """Poisson's ratio."""


class Stiffness(Resolution):
    """Stiffness and expansion of a packing."""

    what: str
    """Property: `stiffness`."""
    tensor: list[list[float]]
    """The tensor: extrapolated from three sizes of voxels or tetrahedra where they show an order, its diagonal within Reuss and Voigt."""
    error: list[list[float]]
    """Error of each entry, by the changes from size to size."""
    fine: list[list[float]]
    """The tensor on the voxels or tetrahedra."""
    coarse: list[list[float]] | None
    """The tensor on those of twice the size; of a label volume with displacements that are trilinear over blocks of 2 x 2 x 2 voxels."""
    isotropic: Isotropic
    """Constants of the nearest isotropic material."""
    isotropic_error: Isotropic
    """Their estimated errors."""
    expansion: list[float]
    """Strains xx, yy, zz, yz, zx, xy of the free specimen by the eigenstrains of its phases."""
    expansion_error: list[float]
    """Estimated error of each strain."""
    bounds: ElasticBounds
    """Bounds on an isotropic mixture of the phases."""
    phases: list[ElasticShare]
    """Phases with their volumes."""
    warnings: list[str]
    """What a reader should know."""


class Unloading(Resolution, At):
    """Young's moduli of a specimen at a moment of its test."""

    what: str
    """Property: `stiffness`."""
    youngs_modulus_mpa: list[float | None]
    """Along x, y, z between smooth ends, MPa; `None` where not asked for."""
    error: list[float | None]
    """Their errors, MPa."""
    fine: list[float | None]
    """On the tetrahedra, MPa."""
    phases: list[ElasticShare]
    """Phases with their volumes and the constants before the test."""
    warnings: list[str]
    """What a reader should know."""


class CurveFigures(TypedDict):
    """Figures of a curve."""

    modulus_mpa: float
    """Secant to 30 % of the peak, MPa, from the stress and the strain at which the path begins."""
    peak_mpa: float
    """Highest stress, MPa."""
    first_peak_mpa: float
    """The stress beyond half of the highest from which the curve first falls by 0.5 %, MPa; else the highest. In splitting it is the strength: the halves may carry more."""
    peak_strain: float
    """Strain at the highest stress."""
    stress_at_end_mpa: float
    """Stress of the last row, MPa."""
    softened: bool
    """Whether the stress fell below 0.8 of the peak."""


class BeyondPeak(TypedDict):
    """Figures of a curve beyond its peak."""

    displacement_to_half_mm: float | None
    """Way of the supports from the peak until half of it is left, mm; `None` where it is not reached. A path that turns counts by its envelope."""
    energy_beyond_peak_n_per_mm: float
    """Work of the supports beyond the peak, N/mm: over the gross section, the ligament of a beam or of a sheared prism, or the plane that splits."""
    energy_beyond_peak_until: float
    """Share of the peak that is left where this work ends: 0.2, or more where the test ends earlier."""


class Lateral(TypedDict):
    """Lateral figures of a specimen that is pressed."""

    poisson_ratio: NotRequired[float | None]
    """Lateral over axial strain from the path's begin to 30 % of the peak."""
    lateral_strain_at_peak: NotRequired[float | None]
    """Lateral strain at the peak, positive where the specimen widens."""
    least_volume_over_peak: NotRequired[float | None]
    """Stress at which the volume is least, over the peak; beyond it the specimen dilates."""


class Setup(TypedDict):
    """The loads and measures that a test has, its turns, supports and gauges; none of plain compression and tension."""

    pressure_mpa: NotRequired[float | None]
    """Lateral pressure of a triaxial test, MPa."""
    stress_ratio: NotRequired[float | None]
    """Lateral over axial stress of a biaxial test."""
    span_mm: NotRequired[float | None]
    """Distance of a beam's rollers, mm."""
    strip_mm: NotRequired[float | None]
    """Width of the strips of a splitting test, or of a beam's rollers, mm."""
    expansion: NotRequired[dict[str, float | None] | None]
    """Linear strains of the phases without stress."""
    turns: NotRequired[list[dict[str, float | str]]]
    """Places at which the path turns."""
    rate_effect: NotRequired[bool | None]
    """Whether strengths grew with the rate of strain, in a test in real time."""
    starts_moving: NotRequired[bool]
    """Whether it began with the speeds of a uniform strain."""
    supports: NotRequired[list[dict[str, object]]]
    """Supports and loads."""
    gauges: NotRequired[list[dict[str, object]]]
    """Gauges, each a column of the curve."""


class Scatter(TypedDict):
    """Scatter of the strengths of mortar and ITZ over the specimen, for the law `meso`.  One factor multiplies strengths, peak strain and energies of a place, so that openings of cracks keep their law. Stiffness has no scatter."""

    coefficient_of_variation: float
    """Standard deviation of the strengths over their mean; 0 is no scatter."""
    correlation_length_mm: float
    """Distance at which the covariance has fallen to 1/e, mm."""
    distribution: str
    """Distribution of the strengths; weibull unless given."""
    covariance: str
    """Covariance of the Gaussian field over the distance; squared-exponential unless given."""
    phases: list[str]
    """Phases that scatter, by one field; mortar and itz unless given."""
    seed: int
    """Seed of the field, which the packing does not depend on; 1 unless given."""


class Energies(TypedDict):
    """Energies at the end of a test, mJ."""

    kinetic: float
    """Kinetic energy."""
    internal: float
    """Work of the elements' forces: stored, dissipated and hourglass energy."""
    external: float
    """Work of the plates."""
    friction_work: float
    """Dissipated by friction on the plates."""
    hourglass: float
    """Energy of hourglass modes."""
    dissipated: float
    """Dissipated in cracks, crushing and plastic flow."""


class PhaseResult(TypedDict):
    """A phase of a test."""

    name: str
    """Name in lower case."""
    volume_fraction: float
    """Volume of its cells in the test over the specimen's gross volume."""
    exact_fraction: float | None
    """Volume of the exact bodies over the specimen's, where known."""
    dissipated_mj: float
    """Dissipated in its cells, mJ; in cohesive faces, too, for the ITZ."""
    youngs_modulus_mpa: float
    """Young's modulus before the test, MPa."""
    poisson_ratio: float
    """Poisson's ratio before the test."""


class TestResult(Setup, CurveFigures, BeyondPeak, Lateral):
    """Content of `result.json`, without seconds."""

    version: str
    """Of mesocrete."""
    seed: int
    """Of the packing."""
    fraction: float
    """Of the packing."""
    mesh: dict[str, object]
    """The options of the mesh."""
    frames: list[dict[str, str | int | float]]
    """File, number, strain and stress of every frame."""
    seconds: dict[str, float]
    """Wall times by part, s."""
    test: str
    """The named test."""
    friction: float
    """Coulomb's coefficient between plates and specimen."""
    control: str
    """How the plates kept their speed."""
    law: str
    """The law of mortar and ITZ."""
    smoothing: str
    """Strain smoothing."""
    elements: int
    """Cells of the mesh."""
    cohesive_elements: int
    """Cohesive elements of the mesh."""
    steps: int
    """Steps taken."""
    steps_planned: int
    """Steps of the whole test at the plates' full speed."""
    time_step_s: float
    """s."""
    stable_time_step_s: float
    """Longest step that would have needed no mass, s."""
    added_mass_percent: float
    """Mass added over the specimen's own."""
    rate_at_peak_per_s: NotRequired[float | None]
    """Rate of strain at the peak between two plates in real time, 1/s."""
    kinetic_over_internal_max: float
    """Largest kinetic over internal energy after the ramp; from half the peak on, where the peak lies within the ramp."""
    kinetic_over_internal_to_half_peak: float
    """Largest kinetic over internal energy until the stress has fallen to half its peak; to the peak under a lateral tension."""
    energy_balance_error: float
    """Largest difference of work and energies over the work: what loose nodes lose when they meet a plate again, and rounding."""
    hourglass_over_internal: float
    """Largest hourglass over internal energy after the ramp."""
    energies: Energies
    """Energies at the end, mJ."""
    joined_pairs: int
    """Pairs of aggregates that share nodes in the mesh, or did before mortar separated them there."""
    joined_cells: int
    """Cells of these aggregates that became mortar, in the mesh and in the test."""
    phases: list[PhaseResult]
    """Phases of the test."""
    columns: NotRequired[list[str]]
    """Columns of the curve after those of every test: gauges, and forces of supports in N."""
    strains_at_end: NotRequired[dict[str, float]]
    """Means of the gauges after the growth in a test that moves no support: the strains of an expansion."""
    broken_stone: float | None
    """Share of the aggregates' volume that lost more than half of its stiffness; `None` where stone does not break."""
    scatter: NotRequired[Scatter | None]
    """Scatter of the strengths of mortar and ITZ; absent where they have none."""
    phase_error: float | None
    """Volume of the phase that is farthest off its exact one, as a share of this, signed; `None` where it is not known."""
    phase_error_of: str | None
    """Name of the phase that is farthest off, in lower case."""
    flags: list[str]
    """Faults that a strength must not be cited without, in a few words each: of the mesh, and the speed of the test."""
    ended: str | dict[str, str]
    """How the test ended."""
    warnings: list[str]
    """Warnings, in sentences; those of the mesh come first."""
    errors: list[str]
    """Why the curve is not to be trusted, in sentences."""


class WorkDone(Work):
    """The work and its wall times."""

    seconds: Seconds
    """By stage, s."""
