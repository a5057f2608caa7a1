//! Supports and loads of a mesh as data: a test puts them together, and a deck writes them.

/// Supports and loads of a mesh, and their path in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    /// Name of the test.
    pub test: String,
    /// Plates, strips and rollers.
    pub supports: Vec<RigidSupport>,
    /// Pressures on outer faces.
    pub pressures: Vec<Pressure>,
    /// Linear strains by the numbers of phases, which grow before the path begins; 3 is no phase of a mesh.
    pub strains: Option<[f64; 5]>,
    /// Places where the path turns, mm, its end last; none of a test that moves no support.
    pub path_mm: Vec<f64>,
    /// Axis along which the supports move: 0, 1 or 2.
    pub axis: usize,
    /// Path over this is the strain, mm.
    pub length_mm: f64,
    /// Force over this is the stress, mm2.
    pub section_mm2: f64,
    /// Whether the path presses the specimen.
    pub presses: bool,
    /// Time in which loads grow before the path begins, s; 0 without such loads.
    pub lead_s: f64,
    /// Time of the path, s.
    pub duration_s: f64,
    /// Time increment that mass scaling keeps, s.
    pub time_increment_s: f64,
    /// Whether all phases are elastic, so that statics give the answer.
    pub is_elastic: bool,
}

/// A rigid support of some nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSupport {
    /// Its name.
    pub name: String,
    /// Axis of its side: 0, 1 or 2.
    pub axis: usize,
    /// Whether its side is the upper one across the axis.
    pub is_upper: bool,
    /// The mesh's nodes under it.
    pub nodes: Vec<u32>,
    /// Its action on the nodes.
    pub hold: Hold,
    /// Its way along the axis for each mm of the path.
    pub moves: f64,
    /// Force that presses it on the specimen when the path begins, N; 0 for none.
    pub force_n: f64,
    /// Its force over the force of the test; `None` where it follows the path.
    pub force_ratio: Option<f64>,
    /// Whether it is a strip beside the middle, which the specimen turns on.
    pub is_beside: bool,
}

/// Action of a support on its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// It presses and rubs with this coefficient of friction.
    Plate(f64),
    /// It is glued on.
    Glued,
}

/// A pressure on outer faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Its name.
    pub name: String,
    /// Cells, and the number of the face of each.
    pub faces: Vec<(u32, usize)>,
    /// The pressure when the path begins, MPa.
    pub mpa: f64,
}
