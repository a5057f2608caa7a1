//! Words as an enemy or a tired user would type them: good command lines, mixed by chance.

use crate::command_line::command_line;

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
fn what_is_validated_is_what_the_command_accepts() {
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
