//! `mesocrete devices`: what `solve --device` can take, and whether it keeps the promise of the same bytes.

use crate::failure::{Failure, RUN};
use crate::outputs::{Target, Unit};
use crate::stderr;
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_gpu::DeviceName;
use meso_solve::{Geometry, Run, Sample, Test};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Run a small test on every device and on this processor, and compare their curves bit by bit
    #[arg(long)]
    check: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let devices = meso_gpu::devices();
    if devices.is_empty() {
        stderr::line(
            "no device; --device takes one by a driver of CUDA or OpenCL (Debian, without a GPU: pocl-opencl-icd)",
        );
    }
    let lines: Vec<String> = devices.iter().map(|device| line(device, args.check)).collect::<Result<_, _>>()?;
    Unit::default().fill(&Target::Stdout, false, |out| lines.iter().try_for_each(|line| writeln!(out, "{line}")))?;
    Ok(if lines.iter().any(|line| line.contains(FAILED)) { RUN } else { 0 })
}

const FAILED: &str = "; failed: ";

fn line(device: &DeviceName, is_checked: bool) -> Result<String, Failure> {
    let mut line = format!("{device}, {:.1} GB", device.memory as f64 / 1e9);
    device.faults.iter().for_each(|fault| line += &format!("; {fault}"));
    if is_checked {
        match difference(device)? {
            Ok(0.0) => line += "; same bytes as the processor",
            Ok(difference) => {
                line += &format!("; stresses differ by {difference:.1e} of the peak from the processor's");
            }
            Err(why) => line += &format!("{FAILED}{why}"),
        }
    }
    Ok(line)
}

/// Largest difference of the stresses of a small test from the processor's, over the peak.
fn difference(device: &DeviceName) -> Result<Result<f64, String>, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::Run(error.to_string());
    let specimen = Specimen::cube(20.0);
    let spec = Spec { specimen: specimen.clone(), fraction: 0.2, seed: 1, ..Spec::default() };
    let model = meso_core::pack(&spec, &Silent).map_err(|error| usage(&error))?;
    let options =
        MeshOptions { method: Method::FITTED, element_size_mm: 4.0, itz: ItzForm::None, ..Default::default() };
    let mesh = mesh::build(&model, &options, &Tools::default()).map_err(|error| usage(&error))?;
    let mut materials = Materials::default();
    materials.mortar_strength.crushing_energy_n_per_mm = 0.5;
    let test = Test { rows: 100, ..Test::default() };
    let test = Test { time_step_s: Some(test.duration_s(&Geometry::of(&specimen)) / 1500.0), ..test };
    let prepare = || Run::new(Sample::of(&mesh, &specimen, &options), &materials, &test).map_err(|error| usage(&error));
    let (mut here, mut there) = (prepare()?, prepare()?);
    if let Err(error) = meso_gpu::attach(&mut there, device) {
        return Ok(Err(error.to_string()));
    }
    let [expected, got] = [&mut here, &mut there].map(|run| run.to_end(&Silent, &Silent));
    if let Some(error) = got.result.errors.first() {
        return Ok(Err(error.clone()));
    }
    let pairs = expected.curve.iter().zip(&got.curve);
    let same = expected.curve == got.curve;
    let most = pairs.map(|(a, b)| (a.stress_mpa - b.stress_mpa).abs()).fold(0.0, f64::max);
    Ok(Ok(if same { 0.0 } else { (most / expected.result.figures.peak_mpa).max(f64::MIN_POSITIVE) }))
}
