//! The work of `mesocrete effective`: tensors, page and fields of a saved model or a label volume.

use super::flags::Args;
use super::settings::{Values, wrong};
use crate::failure::Failure;
use crate::outputs::{Target, Unit};
use crate::own_folder::OwnFolder;
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_core::Model;
use meso_core::watch::Stage;
use meso_effective::results::{FIGURES, Found, PAGE, PropertyField, write_figures, write_page};
use meso_effective::{
    Effective, LabelPhases, LabelSpecimen, Phases, Property, Stiffness, effective, effective_in_tetrahedra,
    effective_of_labels, stiffness, stiffness_in_tetrahedra, stiffness_of_labels,
};
use std::time::Instant;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let values = args.values()?;
    let force = args.writing.force;
    let names = args.files();
    let _own = OwnFolder::open(&args.output)?;
    let target = |name: &str| Target::new(&args.output.join(name), force);
    names.iter().try_for_each(|name| target(name).map(drop))?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Solve, 20.0));
    let subject = Subject::read(args, values, &watch)?;
    subject.accept(args)?;
    let (mut found, mut fields) = (Vec::new(), Vec::new());
    for property in args.properties() {
        let (result, theirs) = subject.solve(args, property, &watch)?;
        found.push(result);
        fields.extend(theirs);
    }
    if args.what.stiffness {
        let (result, theirs) = subject.solve_stiffness(args, &watch)?;
        found.push(result);
        fields.extend(theirs);
    }
    watch.finish();
    let mut unit = Unit::default();
    for field in &fields {
        unit.fill(&target(&field.file())?, force, |out| field.write(out))?;
    }
    unit.fill(&target(FIGURES)?, force, |out| write_figures(&found, out))?;
    unit.fill(&target(PAGE)?, force, |out| write_page(&found, &fields, out))?;
    unit.commit()?;
    found.iter().for_each(|(of, _)| tell(of, args.writing.quiet));
    if !args.writing.quiet {
        names.iter().for_each(|name| stderr::line(format!("wrote {}", args.output.join(name).display())));
    }
    Ok(0)
}

/// A specimen with the values of its phases.
enum Subject {
    Packing(Box<Model>, Box<Phases>),
    Labels(LabelSpecimen, LabelPhases),
}

impl Subject {
    fn read(args: &Args, values: Values, watch: &Watch) -> Result<Self, Failure> {
        Ok(match values {
            Values::Packing(phases) => Self::Packing(Box::new(inputs::model(&args.model, watch)?), phases),
            Values::Labels(phases) => Self::Labels(args.labels()?, phases),
        })
    }

    /// Edge of a voxel, mm.
    fn size(&self, args: &Args) -> f64 {
        match self {
            Self::Packing(model, _) => args.size(&model.spec),
            Self::Labels(specimen, _) => specimen.spacing_mm[0],
        }
    }

    fn solve(&self, args: &Args, what: Property, watch: &Watch) -> Result<Solved, Failure> {
        let options = args.options(what, self.size(args));
        let begun = Instant::now();
        let found = match self {
            Self::Packing(model, phases) if args.in_tetrahedra() => {
                effective_in_tetrahedra(&**model, phases, &options, self.size(args), watch)
                    .map(|(found, fields)| (found, all(fields, |field| PropertyField::MeshFlux(what, field))))
            }
            Self::Packing(model, phases) => effective(&**model, phases, &options, watch)
                .map(|(found, fields)| (found, all(fields, |field| PropertyField::Flux(what, field)))),
            Self::Labels(specimen, phases) => effective_of_labels(specimen, phases, &options, watch)
                .map(|(found, fields)| (found, all(fields, |field| PropertyField::Flux(what, field)))),
        };
        let (found, fields) = found.map_err(|error| wrong(&error))?;
        Ok(((Found::Flux(Box::new(found)), begun.elapsed().as_secs_f64()), fields))
    }

    fn solve_stiffness(&self, args: &Args, watch: &Watch) -> Result<Solved, Failure> {
        let options = args.stiffness_options(self.size(args));
        let begun = Instant::now();
        let found = match self {
            Self::Packing(model, phases) if args.in_tetrahedra() => {
                stiffness_in_tetrahedra(&**model, &phases.stiffness, &options, self.size(args), watch)
                    .map(|(found, fields)| (found, all(fields, PropertyField::MeshStress)))
            }
            Self::Packing(model, phases) => stiffness(&**model, &phases.stiffness, &options, watch)
                .map(|(found, fields)| (found, all(fields, PropertyField::Stress))),
            Self::Labels(specimen, phases) => stiffness_of_labels(specimen, phases, &options, watch)
                .map(|(found, fields)| (found, all(fields, PropertyField::Stress))),
        };
        let (found, fields) = found.map_err(|error| wrong(&error))?;
        Ok(((Found::Stiffness(Box::new(found)), begun.elapsed().as_secs_f64()), fields))
    }

    /// Refuses voxels out of range and beyond the memory, for all properties before any of them is computed.
    fn accept(&self, args: &Args) -> Result<(), Failure> {
        let size = self.size(args);
        let properties = args.properties().into_iter().map(Some).chain(args.what.stiffness.then_some(None));
        for property in properties {
            let name = property.map_or("stiffness", Property::name);
            match self {
                Self::Packing(model, _) => {
                    let (cells, flag) = match args.in_tetrahedra() {
                        true => ("tetrahedra", "--element-size-mm"),
                        false => ("voxels", "--voxel-size-mm"),
                    };
                    let work = format!("the {name} of {cells} of {size} mm");
                    room::accept_in_memory(&work, args.bytes(&model.spec, property)?, (flag, size))?;
                }
                Self::Labels(specimen, phases) => {
                    let counts = specimen.volume.counts;
                    let checked = match property {
                        Some(property) => phases.values(property, &specimen.volume).map(drop),
                        None => phases.moduli(&specimen.volume).map(drop),
                    };
                    checked.map_err(|error| wrong(&error))?;
                    let bytes = property.map_or_else(
                        || args.stiffness_options(size).bytes_of(counts),
                        |property| args.options(property, size).bytes_of(counts),
                    );
                    room::accept_image(&format!("the {name} of the volume"), bytes)?;
                }
            }
        }
        Ok(())
    }
}

/// A result, its seconds, and its fields.
type Solved = ((Found, f64), Vec<PropertyField>);

fn all<T>(fields: Vec<T>, of: impl Fn(T) -> PropertyField) -> Vec<PropertyField> {
    fields.into_iter().map(of).collect()
}

/// Prints the result with its errors, then warnings.
fn tell(found: &Found, quiet: bool) {
    if !quiet {
        stderr::line(match found {
            Found::Flux(found) => flux_line(found),
            Found::Stiffness(found) => stiffness_line(found),
        });
    }
    found.warnings().iter().for_each(|warning| stderr::line(format!("warning: {warning}")));
}

/// The diagonal.
fn flux_line(found: &Effective) -> String {
    let entry = |axis: usize| {
        let (value, error) = (found.tensor[axis][axis]?, found.error[axis][axis]?);
        Some(format!("{} {value:.5} +- {error:.5}", ["x", "y", "z"][axis]))
    };
    let entries: Vec<String> = (0..3).filter_map(entry).collect();
    let (low, high) = (found.bounds.hashin_shtrikman_lower, found.bounds.hashin_shtrikman_upper);
    let name = found.what.name();
    format!("{name}: {}; Hashin-Shtrikman {low:.5} to {high:.5}", entries.join(", "))
}

/// Constants of the nearest isotropic material, and the expansion if there is one.
fn stiffness_line(found: &Stiffness) -> String {
    let (is, error) = (&found.isotropic, &found.isotropic_error);
    let modulus = format!("E {:.0} +- {:.0} MPa", is.youngs_modulus_mpa, error.youngs_modulus_mpa);
    let ratio = format!("nu {:.4} +- {:.4}", is.poisson_ratio, error.poisson_ratio);
    let [x, y, z, ..] = found.expansion;
    let free = found.phases.iter().any(|phase| phase.eigenstrain != 0.0);
    let expansion = if free { format!("; free strain x {x:.3e}, y {y:.3e}, z {z:.3e}") } else { String::new() };
    format!("stiffness: {modulus}, {ratio}{expansion}")
}
