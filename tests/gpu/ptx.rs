//! The kernels as CUDA compiles them: no operation is fused, approximated or flushed; registers stay within the card's.

use crate::same_bytes::cube;
use meso_solve::{LawName, Smoothing, Test};
use std::path::Path;
use std::process::Command;

/// Instructions that would cost the promise of the same bytes.
const FORBIDDEN: [&str; 6] = ["fma.rn.f64", "fma.rn.ftz", ".approx", ".ftz", "mad.f32", "div.full"];
const MOST_REGISTERS: u32 = 96;
const MOST_SHARED: u32 = 48 << 10;

fn source(law: LawName, smoothing: Smoothing, threads: usize) -> String {
    let test = Test { law, smoothing: Some(smoothing), ..Test::default() };
    meso_gpu::source(&cube(24.0, 4.0).run(&test), threads).unwrap()
}

#[test]
fn cuda_rounds_every_operation_of_the_kernels_by_itself_and_spills_nothing() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (law, smoothing) in
        [(LawName::Cdp, Smoothing::Edges), (LawName::Cdpm2, Smoothing::Edges), (LawName::Cdp, Smoothing::None)]
    {
        for architecture in ["80", "90"] {
            let source = source(law, smoothing, meso_gpu::THREADS);
            std::fs::write(folder.join(format!("{law:?}{smoothing:?}.cu")), &source).unwrap();
            let ptx = match meso_gpu::ptx(&source, &format!("compute_{architecture}")) {
                Err(why) if why.contains("no libnvrtc") => return eprintln!("skipped: {why}"),
                ptx => ptx.unwrap(),
            };
            for word in FORBIDDEN {
                assert!(!ptx.contains(word), "{law:?}: {word}");
            }
            assert!(ptx.contains("div.rn.f32") && ptx.contains("sqrt.rn.f32") && ptx.contains("fma.rn.f32"));
            let path = folder.join(format!("{law:?}{smoothing:?}{architecture}.ptx"));
            std::fs::write(&path, ptx).unwrap();
            assemble(&path, architecture);
        }
    }
}

/// Assembles a kernel's PTX and compares its registers, spills and shared memory with the bars.
fn assemble(path: &Path, architecture: &str) {
    let arguments = ["-v", &format!("-arch=sm_{architecture}"), "-o", "/dev/null"];
    let Ok(output) = Command::new("ptxas").args(arguments).arg(path).output() else {
        return eprintln!("skipped: no ptxas (pip: nvidia-cuda-nvcc)");
    };
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{report}");
    let number_before = |line: &str, word: &str| -> u32 {
        let before = line.split(word).next().filter(|_| line.contains(word));
        before.and_then(|text| text.split_whitespace().last()?.parse().ok()).unwrap_or(0)
    };
    for line in report.lines() {
        assert_eq!(number_before(line, " bytes spill"), 0, "{line}");
        assert!(number_before(line, " registers") <= MOST_REGISTERS, "{line}");
        assert!(number_before(line, " bytes smem") <= MOST_SHARED, "{line}");
    }
}
