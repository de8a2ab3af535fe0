//! Edges of triangles, each numbered once.

#[derive(Debug)]
pub(super) struct Edges {
    /// The lower and the higher vertex of each edge.
    pub(super) ends: Vec<[u32; 2]>,
    /// For each triangle its three edges; entry `k` is the one from corner `k` to the next.
    pub(super) sides: Vec<[u32; 3]>,
}

impl Edges {
    /// Numbered by their vertices.
    pub(super) fn new(triangles: &[[u32; 3]]) -> Edges {
        let mut keys: Vec<(u64, u32)> = Vec::with_capacity(3 * triangles.len());
        for (triangle, corners) in (0..).zip(triangles) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                keys.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), 3 * triangle + k as u32));
            }
        }
        keys.sort_unstable();
        let mut edges = Edges { ends: Vec::with_capacity(keys.len() / 2), sides: vec![[0; 3]; triangles.len()] };
        for same in keys.chunk_by(|a, b| a.0 == b.0) {
            for &(_, half) in same {
                edges.sides[half as usize / 3][half as usize % 3] = edges.ends.len() as u32;
            }
            edges.ends.push([(same[0].0 >> 32) as u32, same[0].0 as u32]);
        }
        edges
    }
    /// Whether the triangles run along each edge as often one way as the other: whether they close.
    pub(super) fn are_balanced(&self, triangles: &[[u32; 3]]) -> bool {
        let mut balance = vec![0_i32; self.ends.len()];
        for (corners, sides) in triangles.iter().zip(&self.sides) {
            for k in 0..3 {
                balance[sides[k] as usize] += if corners[k] < corners[(k + 1) % 3] { 1 } else { -1 };
            }
        }
        balance.iter().all(|&balance| balance == 0)
    }
}
