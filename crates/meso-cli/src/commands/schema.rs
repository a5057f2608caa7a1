//! `mesocrete schema`: the options as JSON Schemas.

use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use meso_core::Spec;
use meso_core::export::abaqus::DeckOptions;
use meso_core::materials::Materials;
use meso_core::mesh::MeshTable;
use meso_core::statistics;
use serde_json::Value;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Which options: a spec's, or the keywords of Python's `mesh`, `write` (of a deck), `solve` (and a TEST.toml), `effective`,
    /// `fit`, `statistics` and `materials`
    #[arg(value_enum, default_value = "spec")]
    of: Of,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Of {
    Spec,
    Mesh,
    Deck,
    Solve,
    Effective,
    Fit,
    Statistics,
    Materials,
}

impl Of {
    fn schema(self) -> Value {
        match self {
            Self::Spec => Spec::schema(),
            Self::Mesh => Spec::schema_of::<MeshTable>(),
            Self::Deck => Spec::schema_of::<DeckOptions>(),
            Self::Solve => Spec::schema_of::<meso_solve::Test>(),
            Self::Effective => Spec::schema_of::<meso_ask::EffectiveAsk>(),
            Self::Fit => Spec::schema_of::<meso_ask::FitAsk>(),
            Self::Statistics => Spec::schema_of::<statistics::StatisticsOptions>(),
            Self::Materials => Spec::schema_of::<Materials>(),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    Unit::default().fill(&Target::Stdout, false, |out| {
        serde_json::to_writer_pretty(&mut *out, &args.of.schema())?;
        writeln!(out)
    })?;
    Ok(0)
}
