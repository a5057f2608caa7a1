//! The kernels as CUDA compiles them: no operation is fused, approximated or flushed; registers stay within the card's.

use crate::same_bytes::{cube, meshed, scattered};
use meso_core::mesh::ItzForm;
use meso_core::specimen::Specimen;
use meso_solve::{Expansion, LawName, Smoothing, Test, TestKind};
use std::path::Path;
use std::process::Command;

/// Instructions that would cost the promise of the same bytes.
const FORBIDDEN: [&str; 6] = ["fma.rn.f64", "fma.rn.ftz", ".approx", ".ftz", "mad.f32", "div.full"];
/// Registers of five groups of 128 threads, and of the four of a law whose strengths grow or scatter.
const MOST_REGISTERS: [u32; 2] = [96, 128];
const MOST_SHARED: u32 = 48 << 10;

#[test]
fn cuda_rounds_every_operation_of_the_kernels_by_itself_and_spills_nothing() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (smeared, cohesive) = (cube(24.0, 4.0), meshed(Specimen::cube(20.0), 4.0, ItzForm::Cohesive));
    let scattered = scattered(cube(24.0, 4.0));
    let (law, kind, smoothing) = (LawName::Meso, TestKind::Triaxial, Some(Smoothing::None));
    let expansion = Some(Expansion { aggregate: 1e-4.into(), ..Expansion::default() });
    for (name, body, test) in [
        ("plain", &smeared, Test::default()),
        ("plain-cdpm2", &smeared, Test { law: LawName::Cdpm2, ..Test::default() }),
        ("plain-tetrahedra", &smeared, Test { smoothing, ..Test::default() }),
        ("pressed-meso", &smeared, Test { law, kind, ..Test::default() }),
        ("swelling-cohesive", &cohesive, Test { expansion, ..Test::default() }),
        ("fast", &smeared, Test { kind: TestKind::Impact, rate_effect: true, ..Test::default() }),
        ("scattered", &scattered, Test::default()),
        ("fast-scattered", &scattered, Test { kind: TestKind::Impact, rate_effect: true, ..Test::default() }),
    ] {
        for architecture in ["80", "90"] {
            let source = meso_gpu::source(&body.run(&test), meso_gpu::THREADS).unwrap();
            std::fs::write(folder.join(format!("{name}.cu")), &source).unwrap();
            let ptx = match meso_gpu::ptx(&source, &format!("compute_{architecture}")) {
                Err(why) if why.contains("no libnvrtc") => return eprintln!("skipped: {why}"),
                ptx => ptx.unwrap(),
            };
            for word in FORBIDDEN {
                assert!(!ptx.contains(word), "{name}: {word}");
            }
            assert!(ptx.contains("div.rn.f32") && ptx.contains("sqrt.rn.f32") && ptx.contains("fma.rn.f32"));
            let path = folder.join(format!("{name}{architecture}.ptx"));
            std::fs::write(&path, ptx).unwrap();
            assemble(&path, architecture, MOST_REGISTERS[usize::from(test.rate_effect || name.ends_with("scattered"))]);
        }
    }
}

/// Assembles a kernel's PTX and compares its registers, spills and shared memory with the bars.
fn assemble(path: &Path, architecture: &str, most_registers: u32) {
    let arguments = ["-v", &format!("-arch=sm_{architecture}"), "-o", "/dev/null"];
    let assembler = std::env::var_os("PTXAS").unwrap_or_else(|| "ptxas".into());
    let Ok(output) = Command::new(assembler).args(arguments).arg(path).output() else {
        return eprintln!("skipped: no ptxas (pip: nvidia-cuda-nvcc)");
    };
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{report}");
    let number_before = |line: &str, word: &str| -> u32 {
        let before = line.split(word).next().filter(|_| line.contains(word));
        before.and_then(|text| text.split_whitespace().last()?.parse().ok()).unwrap_or(0)
    };
    for line in report.lines() {
        assert_eq!(number_before(line, " bytes spill"), 0, "{path:?} {line}");
        assert!(number_before(line, " registers") <= most_registers, "{path:?} {line}");
        assert!(number_before(line, " bytes smem") <= MOST_SHARED, "{path:?} {line}");
    }
}
