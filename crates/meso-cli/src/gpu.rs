//! Devices of CUDA and OpenCL, which take the steps of a test. The file `no_gpu.rs` replaces this one where the feature `gpu` is
//! off.

use crate::failure::Failure;
use crate::stderr;
use meso_ask::AskError;
use meso_core::materials::Materials;
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Tools};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_gpu::DeviceName;
use meso_solve::{Geometry, Run, Sample, Test};
use meso_study::Attached;

pub(crate) use meso_gpu::{Choice, Lease as Device};

/// Printed where there is no device to list.
pub(crate) fn none() -> String {
    let option = stderr::flag("device");
    format!("no device; {option} takes one by a driver of CUDA or OpenCL (Debian, without a GPU: pocl-opencl-icd)")
}

/// Takes the device that is meant; none for this processor.
pub(crate) fn find(choice: &Choice) -> Result<Option<Device>, Failure> {
    choice.find().map_err(Failure::Usage)
}

/// Finds the device of a name and puts a run there; the doubt about a device that cannot keep the promise, and the hold on it.
pub(crate) fn device(name: &str, run: Option<&mut Run<'_>>) -> Result<Attached, AskError> {
    let choice: Choice = name.parse().map_err(AskError::Usage)?;
    let (Some(lease), Some(run)) = (find(&choice)?, run) else { return Ok(Attached::default()) };
    meso_gpu::attach(run, &lease.device).map_err(|error| AskError::Run(error.to_string()))?;
    Ok(Attached { doubt: warning(&lease.device)?, hold: Some(Box::new(lease)) })
}

/// Puts a run onto a device.
pub(crate) fn attach(run: &mut Run, Device { device, .. }: &Device, quiet: bool) -> Result<(), Failure> {
    let bytes = meso_gpu::attach(run, device).map_err(|error| Failure::Run(error.to_string()))?;
    if !quiet {
        stderr::line(format!("on {device}, {:.0} MB", bytes as f64 / 1e6));
    }
    warning(device)?.into_iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
    Ok(())
}

/// The warning of a device that cannot keep the promise, with the measured difference.
fn warning(device: &DeviceName) -> Result<Option<String>, Failure> {
    let Some(warning) = device.warning() else { return Ok(None) };
    let measured = measured(difference(device)?);
    let check = stderr::flag("check");
    Ok(Some(format!("{warning}; in a small test: {measured} (`mesocrete devices {check}`)")))
}

/// A line about every device, with the result of its check where one is asked for.
pub(crate) fn lines(is_checked: bool) -> Result<Vec<String>, Failure> {
    meso_gpu::devices().iter().map(|device| line(device, is_checked)).collect()
}

/// Begins the end of the line of a device that could not take the check's test.
pub(crate) const FAILED: &str = "; failed: ";

fn line(device: &DeviceName, is_checked: bool) -> Result<String, Failure> {
    let mut line = format!("{device}, {:.1} GB", device.memory as f64 / 1e9);
    device.faults.iter().chain(&device.refusal).for_each(|fault| line += &format!("; {fault}"));
    if is_checked && device.refusal.is_none() {
        match difference(device)? {
            Err(why) => line += &format!("{FAILED}{why}"),
            found => line += &format!("; {}", measured(found)),
        }
    }
    Ok(line)
}

/// The result of a check in words.
fn measured(difference: Result<f64, String>) -> String {
    match difference {
        Ok(0.0) => "same bytes as the processor".to_owned(),
        Ok(difference) => format!("stresses differ by {difference:.1e} of the peak from the processor's"),
        Err(why) => why,
    }
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
    materials.mortar_strength.crushing_energy_n_per_mm = Some(0.5);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_cannot_keep_the_promise_is_used_with_a_warning_that_has_the_measured_difference() {
        assert_eq!(measured(Ok(3e-5)), "stresses differ by 3.0e-5 of the peak from the processor's");
        let Some(device) = meso_gpu::devices().into_iter().find(|device| device.faults.is_empty()) else { return };
        assert!(warning(&device).unwrap().is_none());
        // pocl does not flush denormals: the check finds no difference.
        let faulty = DeviceName { faults: vec!["it flushes denormals"], ..device };
        let text = warning(&faulty).unwrap().unwrap();
        assert!(text.contains("it flushes denormals; results are not"), "{text}");
        assert!(text.contains("in a small test: same bytes as the processor ("), "{text}");
    }
}
