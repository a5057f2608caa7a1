//! Files as an enemy or a bad disk would write them: mutated by chance, from seeds that are good.

use crate::targets::{TARGETS, Target};
use meso_core::spec::Spec;
use meso_core::{Silent, pack, saved};
use std::time::{Duration, Instant};

/// Inputs of each target before they are mutated.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let recipes = || meso_core::recipes::Recipe::ALL.iter().map(|recipe| recipe.text.as_bytes().to_vec());
    match target {
        "spec" => recipes().collect(),
        // With its checksum nearly every change would end there.
        "saved-model" => vec![model(), unsealed(&model())],
        "stl" => {
            [stl(b"solid a\nfacet normal 0 0 0\nouter loop\n"), stl(&[0; 84])].into_iter().chain(indexed()).collect()
        }
        "sieve-table" => [&b"sieve_mm,passing\n4,0.1\n8,0.45\n16,1\n"[..], b"sieve_mm;passing_percent\n4;10\n16;100\n"]
            .map(<[u8]>::to_vec)
            .to_vec(),
        "volume" => vec![npy(), vti(), tif()],
        "materials" => vec![b"[mortar]\nyoungs_modulus_mpa = 25000\npoisson_ratio = 0.2\n".to_vec()],
        _ => (0..8u8).map(|seed| (0..200u8).map(|i| i.wrapping_mul(37).wrapping_add(seed * 11)).collect()).collect(),
    }
}

/// Label volumes of 2 x 2 x 2, 2 x 2 x 1 and 2 x 2 voxels.
fn npy() -> Vec<u8> {
    let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2), }\n";
    [b"\x93NUMPY\x01\0", &[header.len() as u8, 0][..], header.as_bytes(), &[0, 1, 2, 1, 0, 0, 1, 2]].concat()
}

fn vti() -> Vec<u8> {
    let head = "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><ImageData WholeExtent=\"0 2 0 2 0 1\" \
                Spacing=\"1 1 1\"><CellData><DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/></CellData>";
    [head.as_bytes(), b"<AppendedData encoding=\"raw\">_\x04\0\0\0\0\x01\x02\x01</AppendedData></VTKFile>"].concat()
}

fn tif() -> Vec<u8> {
    let tags: [(u16, u32); 9] =
        [(256, 2), (257, 2), (258, 8), (259, 1), (262, 1), (273, 122), (277, 1), (278, 2), (279, 4)];
    let mut bytes = [&b"II*\0\x08\0\0\0"[..], &[tags.len() as u8, 0]].concat();
    for (tag, value) in tags {
        let tag = tag.to_le_bytes();
        bytes.extend([tag[0], tag[1], 4, 0, 1, 0, 0, 0]);
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    [&bytes[..], &[0, 1, 2, 1]].concat()
}

fn model() -> Vec<u8> {
    let spec = "fraction = 0.2\nspecimen = { kind = 'cube', side_mm = 25 }\ngrading = { d_max_mm = 10 }\n";
    let mut bytes = Vec::new();
    saved::write(&pack(&Spec::from_toml(spec).unwrap(), &Silent).unwrap(), &mut bytes).unwrap();
    bytes
}

/// The bytes of a saved model without its checksum.
fn unsealed(model: &[u8]) -> Vec<u8> {
    let end = model.windows(9).rposition(|part| part == b",\n\"crc32\"").expect("a model ends with its checksum");
    [&model[..end], b"}\n"].concat()
}

/// A tetrahedron as text or, after 84 bytes, as records.
fn stl(head: &[u8]) -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 30.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut bytes = head.to_vec();
    if head.starts_with(b"solid") {
        bytes.clear();
        bytes.extend(b"solid a\n");
        for face in faces {
            bytes.extend(b"facet normal 0 0 0\nouter loop\n");
            face.iter().for_each(|&i: &usize| {
                let [x, y, z] = corners[i];
                bytes.extend(format!("vertex {x} {y} {z}\n").as_bytes());
            });
            bytes.extend(b"endloop\nendfacet\n");
        }
        bytes.extend(b"endsolid a\n");
        return bytes;
    }
    bytes[80..84].copy_from_slice(&4u32.to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        face.iter().for_each(|&i: &usize| corners[i].iter().for_each(|x| bytes.extend(x.to_le_bytes())));
        bytes.extend([0; 2]);
    }
    bytes
}

/// A tetrahedron as OBJ, OFF, and PLY as text and binary.
fn indexed() -> Vec<Vec<u8>> {
    let (vertices, faces) = ("0 0 0\n30 0 0\n0 30 0\n0 0 30\n", [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3u8]]);
    let rows: String = faces.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    let off = format!("OFF\n4 4 6\n{vertices}{rows}");
    let names = faces.iter().map(|f| format!("f {}//1 {} -{}\n", f[0] + 1, f[1] + 1, 4 - f[2]));
    let obj = format!("o a\nv {}{}", vertices.trim_end().replace('\n', "\nv ") + "\n", names.collect::<String>());
    let head = |form: &str| {
        format!(
            "ply\nformat {form} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let mut binary = head("binary_little_endian").into_bytes();
    let numbers = vertices.split_whitespace().map(|x| x.parse::<f32>().expect("a number"));
    numbers.for_each(|x| binary.extend(x.to_le_bytes()));
    for face in faces {
        binary.push(3);
        face.iter().for_each(|&i| binary.extend(i32::from(i).to_le_bytes()));
    }
    vec![obj.into_bytes(), off.into_bytes(), (head("ascii") + vertices + &rows).into_bytes(), binary]
}

/// A generator after G. Marsaglia (xorshift64*).
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16) as usize % end.max(1)
    }
}

/// Words that break numbers, lists and lengths.
const WORDS: [&[u8]; 16] = [
    b"-1",
    b"0",
    b"1e308",
    b"1e-320",
    b"nan",
    b"inf",
    b"[",
    b"]",
    b"{}",
    b"null",
    b"true",
    b"18446744073709551616",
    b"\"",
    b"\xff\xff\xff\xff",
    b"\n",
    b"=",
];

/// Up to four changes: a byte, a word, a number, a part taken out, doubled or moved.
fn mutated(seed: &[u8], chance: &mut Chance) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=chance.below(4) {
        let at = chance.below(bytes.len());
        let end = (at + 1 + chance.below(40)).min(bytes.len());
        match chance.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << chance.below(8),
            1 if at < bytes.len() => bytes[at] = chance.below(256) as u8,
            2 => drop(bytes.splice(at..at, WORDS[chance.below(WORDS.len())].iter().copied())),
            3 => digits(&mut bytes, at, WORDS[chance.below(6)]),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let part = bytes[at..end].to_vec();
                drop(bytes.splice(at..at, part));
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Puts `word` in place of the number at or after `at`.
fn digits(bytes: &mut Vec<u8>, at: usize, word: &[u8]) {
    let Some(first) = bytes[at..].iter().position(u8::is_ascii_digit).map(|ahead| at + ahead) else { return };
    let length = bytes[first..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    bytes.splice(first..first + length, word.iter().copied());
}

/// Runs a target on its seeds, then on mutations until `enough`.
fn feed((name, target): Target, enough: impl Fn(usize) -> bool) {
    let (seeds, mut chance) = (seeds(name), Chance(1));
    seeds.iter().for_each(|seed| target(seed));
    let mut count = 0;
    while !enough(count) {
        target(&mutated(&seeds[chance.below(seeds.len())], &mut chance));
        count += 1;
    }
}

#[test]
fn mutated_files_and_bodies_break_nothing() {
    for target in TARGETS {
        // A packing with its meshes takes a tenth of a second, a model a millisecond, all else microseconds.
        let cases = match target.0 {
            "tiny-mesh" => 10,
            "saved-model" | "offset" | "hull" => 300,
            _ => 2000,
        };
        feed(target, |count| count >= cases);
    }
}

#[test]
#[ignore = "slow: ten seconds for each target; the fuzz targets get a minute"]
fn slow_mutated_files_and_bodies_break_nothing_for_ten_seconds() {
    for target in TARGETS {
        let start = Instant::now();
        feed(target, |_| start.elapsed() > Duration::from_secs(10));
    }
}
