//! Faces as loops of vertices, and the loops of faces around the vertices.

/// Faces as loops of vertex indices, one after the other.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Loops {
    pub(crate) corners: Vec<u32>,
    /// One past the last corner of each face.
    pub(crate) ends: Vec<u32>,
}

/// A face at one of its vertices, and the vertices before and after that one.
#[derive(Clone, Copy, Default)]
struct Corner {
    before: u32,
    after: u32,
    face: u32,
}

impl Loops {
    /// Number of faces.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The vertices of a face.
    #[inline(always)]
    pub(crate) fn face(&self, f: usize) -> &[u32] {
        let start = if f == 0 { 0 } else { self.ends[f - 1] };
        &self.corners[start as usize..self.ends[f] as usize]
    }

    /// The vertices of every face.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|f| self.face(f))
    }

    /// For every vertex the loop of faces around it, counter-clockwise from outside, from the one with the smallest vertex
    /// after it on; none for vertices of no face.
    pub(super) fn around(&self, vertices: usize) -> Self {
        let (starts, around) = self.corners_by_vertex(vertices);
        let mut loops = Self::default();
        loops.corners.reserve(around.len());
        loops.ends.reserve(vertices);
        // By the vertex after: of the corners around one vertex, no two have the same.
        let mut fan = vec![Corner::default(); vertices];
        for v in (0..vertices).filter(|&v| starts[v] < starts[v + 1]) {
            let around = &around[starts[v] as usize..starts[v + 1] as usize];
            around.iter().for_each(|corner| fan[corner.after as usize] = *corner);
            let mut after = around.iter().map(|corner| corner.after).min().expect("not empty");
            for _ in around {
                let corner = fan[after as usize];
                loops.corners.push(corner.face);
                // The next face starts where this one ends.
                after = corner.before;
            }
            loops.ends.push(loops.corners.len() as u32);
        }
        loops
    }

    /// Where the corners at each vertex begin in the list of all.
    fn corners_by_vertex(&self, vertices: usize) -> (Vec<u32>, Vec<Corner>) {
        let mut starts = vec![0_u32; vertices + 1];
        self.corners.iter().for_each(|&v| starts[v as usize + 1] += 1);
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut around = vec![Corner::default(); starts[vertices] as usize];
        for (face, corners) in (0..).zip(self.iter()) {
            let mut before = corners[corners.len() - 2];
            for (vertex, after) in pairs(corners) {
                let slot = &mut next[vertex as usize];
                around[*slot as usize] = Corner { before, after, face };
                *slot += 1;
                before = vertex;
            }
        }
        (starts, around)
    }
}

/// Every corner of a loop with the one after it, from the last one on.
pub(crate) fn pairs(around: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    let mut last = around.last().copied().unwrap_or_default();
    around.iter().map(move |&corner| (std::mem::replace(&mut last, corner), corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faces_around_a_vertex_follow_one_another() {
        // A pyramid over the square 0 1 2 3; vertex 5 is of no face.
        let faces: [&[u32]; 5] = [&[3, 2, 1, 0], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
        let ends = faces.iter().scan(0, |end, face| {
            *end += face.len() as u32;
            Some(*end)
        });
        let around = Loops { corners: faces.concat(), ends: ends.collect() }.around(6);
        let found: Vec<&[u32]> = around.iter().collect();
        let loops: [&[u32]; 5] = [&[1, 4, 0], &[0, 2, 1], &[0, 3, 2], &[4, 3, 0], &[1, 2, 3, 4]];
        assert_eq!(found, loops);
    }
}
