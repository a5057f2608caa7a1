//! Disjoint sets of numbers: each points to one of its set, the least to itself.

/// The least number of the set of `index`.
pub(crate) fn find(root: &mut [u32], mut index: u32) -> u32 {
    while root[index as usize] != index {
        root[index as usize] = root[root[index as usize] as usize];
        index = root[index as usize];
    }
    index
}

/// Makes one set of those of `a` and `b`.
pub(crate) fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}
