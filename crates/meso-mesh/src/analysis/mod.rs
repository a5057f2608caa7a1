//! Changes to a mesh for an analysis, whatever its method: aggregates that mortar parts, their exact volumes, gaps of two elements,
//! time steps that mortar decides, and an ITZ that takes no layer.

mod exact_volumes;
mod gaps;
mod joined;
mod stiff_cells;
mod thin_itz;

pub(crate) use exact_volumes::restore as restore_volumes;
pub(crate) use gaps::split_narrow;
pub(crate) use joined::part as part_joined;
pub(crate) use stiff_cells::spare_stiff;
pub(crate) use thin_itz::{add_cohesive, smear_itz};
