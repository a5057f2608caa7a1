//! Words as an enemy or a tired user would type them: good command lines, mixed by chance.

use crate::command_line::command_line;
use crate::hostile_study::study;

/// Every flag that takes a value, with good and bad ones, and every command.
const WORDS: [&str; 72] = [
    "pack",
    "mesh",
    "solve",
    "study",
    "check",
    "report",
    "convert",
    "image",
    "init",
    "recipes",
    "schema",
    "man",
    "completions",
    "--help",
    "--version",
    "-o",
    "-",
    "m.json",
    "m.json.gz",
    "m.inp",
    "m.vtu",
    "m.pvtu",
    "m.msh",
    "m.step",
    "m.stl",
    "m.npy",
    "m.tif",
    "m.png",
    "m.html",
    "SPEC.toml",
    "--method",
    "voxel",
    "lattice",
    "conforming",
    "--itz",
    "solid",
    "cohesive",
    "none",
    "--element-size-mm",
    "--analysis",
    "compression",
    "tension",
    "elastic",
    "--strain",
    "--friction",
    "--duration",
    "--frames",
    "--section",
    "z=75",
    "--box",
    "0,0,0,50,50,50",
    "--what",
    "share",
    "--of",
    "--voxel-size-mm",
    "--fraction",
    "--seed",
    "--attempts",
    "--min-gap-mm",
    "--time-limit",
    "--threads",
    "--law",
    "0",
    "-1",
    "0.4",
    "1e308",
    "nan",
    "inf",
    "18446744073709551615",
    "--subsamples",
    "--order",
    "\u{0}",
];

/// A generator after G. Marsaglia (xorshift64*).
fn below(state: &mut u64, end: usize) -> usize {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) as usize % end
}

#[test]
fn words_in_any_order_break_nothing() {
    let mut state = 1;
    for _ in 0..1500 {
        let mut line = vec![WORDS[below(&mut state, 13)]];
        line.extend((0..below(&mut state, 8)).map(|_| WORDS[below(&mut state, WORDS.len())]));
        command_line(line.join("\n").as_bytes());
    }
}

#[test]
fn the_validation_accepts_the_lines_that_the_command_accepts() {
    let lines: [(&[&str], bool); 6] = [
        (&["pack", "--fraction", "0.4", "-o", "a.json"], true),
        (&["pack", "--fraction", "1.4"], false),
        (&["pack", "-o", "a.unknown"], false),
        (&["mesh", "m.json", "-o", "a.inp", "--method", "octree"], false),
        (&["image", "m.json", "-o", "a.npy", "--of", "itz"], false),
        (&["convert", "m.json", "-o", "a.stl", "--mortar"], false),
    ];
    for (line, accepted) in lines {
        let args = std::iter::once("mesocrete").chain(line.iter().copied()).map(Into::into);
        assert_eq!(meso_cli::validate(args).is_ok(), accepted, "{line:?}");
    }
}

/// Lines of good and bad studies.
const LINES: [&str; 34] = [
    "recipe = 'rve-60'",
    "outputs = ['a.csv', 'A.CSV']",
    "outputs = ['frame_1.vtu', '../a.csv', 'b.vtu']",
    "outputs = ['m_0.vtu', 'a\u{0}.csv']",
    "[spec]",
    "fraction = 0.2",
    "fraction = nan",
    "specimen = { kind = 'cube', side_mm = 24 }",
    "[over]",
    "seed = { from = 1, to = 9, step = 4 }",
    "seed = { from = -9223372036854775808, to = 9223372036854775807 }",
    "seed = [18446744073709551615, -1, 1e300]",
    "seed = [[], {}, '\u{1f600}']",
    "specimen.side_mm = [30, 40]",
    "specimen = [{ kind = 'sphere' }, 3]",
    "\"grading..d\" = [1]",
    "mesh.itz = ['none', 'cohesive']",
    "mesh.output = [['b.vtu'], ['b.vtu', 'B.vtu']]",
    "mesh = [{}, { output = 'q.inp' }]",
    "solve.friction = [0, 1e999]",
    "[mesh]",
    "output = 'm.inp'",
    "output = ['m.inp', 'm.pvtu', 'm_1.vtu']",
    "output = ['frame.pvtu', 3]",
    "method = 'conforming'",
    "gmsh = './x.sh'",
    "\"gmsh=./x.sh\" = true",
    "element_size_mm = 1e-300",
    "analysis = 'compression'",
    "strict = true",
    "[solve]",
    "test = 'tension'",
    "frames = 18446744073709551615",
    "\"\" = \"\"",
];

#[test]
fn studies_of_lines_in_any_order_break_nothing() {
    let mut state = 7;
    let mut planned = 0;
    for _ in 0..3000 {
        let lines: Vec<&str> = (0..below(&mut state, 9)).map(|_| LINES[below(&mut state, LINES.len())]).collect();
        let text = lines.join("\n");
        study(text.as_bytes());
        planned += usize::from(meso_cli::validate_study(&text).is_ok());
    }
    // Many are refused, some are not.
    assert!((100..2900).contains(&planned), "{planned}");
}
