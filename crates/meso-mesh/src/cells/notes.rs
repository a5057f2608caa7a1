//! Counts that builders leave in a mesh: bridged gaps, thinned shells, cells that changed their phase.

use serde::{Deserialize, Serialize};

/// Decisions of the builder, and how often it took each: every bridged gap and thinned ITZ is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// Whether the cells follow the bodies' facets, in which case they lie in no lattice and crack bands are narrower.
    pub conforming: bool,
    /// Volume of the cells that voids took, which are left out, mm3; a conforming mesh has none to begin with.
    pub voids_mm3: f64,
    /// Nodes that two or more aggregates share: there a gap between them, thinner than the elements can show, is closed.
    pub closed_gaps: usize,
    /// Pairs of aggregates that share nodes.
    pub closed_gap_pairs: usize,
    /// The widest gap between two of these, mm.
    pub widest_closed_gap_mm: f64,
    /// Nodes that two or more aggregates shared and mortar parts now.
    pub parted_nodes: usize,
    /// Pairs of aggregates that mortar parts there.
    pub separated_pairs: usize,
    /// Cells of aggregates that became mortar for it.
    pub parted_cells: usize,
    /// Aggregates that lost some of these.
    #[serde(default)]
    pub parted_aggregates: usize,
    /// Their volume, mm3, before any volume was made good.
    pub parted_mm3: f64,
    /// Cells of aggregates that became mortar, since their stable time step was shorter than that of all mortar.
    pub stiff_cells: usize,
    /// Their volume, mm3.
    pub stiff_mm3: f64,
    /// Edges of mortar between two aggregates that got a node in the middle.
    pub split_gap_edges: usize,
    /// Nodes of aggregates on flat sides of the specimen (across which it does not repeat itself): there a gap between the
    /// two, thinner than the elements can show, is closed.
    pub closed_side_gaps: usize,
    /// Aggregates that have such nodes.
    pub closed_side_gap_aggregates: usize,
    /// The widest gap between one of them and its side, mm.
    pub widest_closed_side_gap_mm: f64,
    /// Nodes of a fitted lattice that belong on a surface and lie off it, since there no angle would be large enough.
    pub off_surface_nodes: usize,
    /// Aggregates too small for their solid ITZ: it takes 0.8 of their centroid's depth instead. Here and in the next three,
    /// layers of shells count as the ITZ does.
    pub thinned_itz_aggregates: usize,
    /// Nodes of the solid ITZ that stopped short, so that no tetrahedron turns over or has too sharp an angle.
    pub thinned_itz_nodes: usize,
    /// Nodes of the solid ITZ where it has no thickness at all; they count among the thinned ones, too.
    pub pinched_itz_nodes: usize,
    /// Inner nodes of a lattice's solid ITZ that left the exact offset, so that no angle is too sharp.
    pub shifted_itz_nodes: usize,
    /// Exact volume inside the shells of the solid ITZ, mm3, where a layer was made and the volume is known: sampling it
    /// takes as long as the mesh.
    #[serde(skip)]
    pub cores_mm3: Option<f64>,
}
