//! Memory that the surface in a file takes, by the numbers that its reader keeps.

use super::ending;

/// Bytes of memory until the surface in a file is proved, or a little more; 0 of a file with another ending than surfaces have.
///
/// 327,680 triangles took 730 bytes each as .stl, .ply, .off and .obj; a polygon of 6 million corners took 154 a corner.
pub fn bytes_of_surface(name: &str, bytes: &[u8]) -> u64 {
    let is_binary = bytes.contains(&0);
    let lines =
        |kept: fn(&[u8]) -> usize| bytes.split(|byte| *byte == b'\n').map(|line| kept(line) as u64).sum::<u64>();
    match ending(name).as_deref() {
        Some("stl") if is_binary => 16 * bytes.len() as u64,
        // 21 words a triangle.
        Some("stl") => 40 * lines(|line| words(line).count()),
        Some("ply") if is_binary => 40 * bytes.len() as u64,
        Some("ply" | "off") => 160 * lines(kept),
        Some("obj") => 160 * lines(kept_of_obj),
        _ => 0,
    }
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Numbers of a line of a .ply or .off that are kept: a face's count and corners, a vertex's position; all of a line of many.
fn kept(line: &[u8]) -> usize {
    const MANY: usize = 64;
    let line = line.split(|byte| *byte == b'#').next().unwrap_or_default();
    let corners = words(line).next().and_then(|word| std::str::from_utf8(word).ok()?.parse::<usize>().ok());
    let count = words(line).count();
    if count > MANY { count } else { count.min(corners.unwrap_or(0).saturating_add(1).max(3)) }
}

/// Words of a line of an .obj that are kept: of faces, and of positions without their colours.
fn kept_of_obj(line: &[u8]) -> usize {
    match words(line).next() {
        Some(b"f") => words(line).count(),
        Some(b"v") => 4,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_take_memory_by_their_numbers() {
        assert_eq!(bytes_of_surface("a/b.OBJ", b"v 0 0 0\nf 1 2 3\n"), 160 * 8);
        assert_eq!(bytes_of_surface("b.obj", b"# v v v v\nv 0 0 0 1 1 1\nvn 0 0 1\nf 1//1 2//1 3//1\n"), 160 * 8);
        assert_eq!(bytes_of_surface("b.off", b"OFF # of a scan\n\n3 1 0\n"), 160 * 4);
        assert_eq!(bytes_of_surface("b.ply", b"0.5 0 0 0 0 1 255 255 255\n3 0 1 2 9 9\n"), 160 * 7);
        assert_eq!(bytes_of_surface("b.off", &b"7 ".repeat(100)), 160 * 100);
        assert_eq!(bytes_of_surface("b.ply", b"ply\n\0\0\0\0"), 40 * 8);
        let triangle = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        let each = bytes_of_surface("b.stl", &triangle.repeat(10)) / 10;
        assert!((730..1000).contains(&each), "{each}");
        assert_eq!(bytes_of_surface("b.stl", &[0; 134]), 16 * 134);
        assert_eq!([bytes_of_surface("b.csv", b"1 2 3"), bytes_of_surface("b", b"1 2 3")], [0, 0]);
    }
}
