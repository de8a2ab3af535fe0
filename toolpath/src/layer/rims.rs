//! The edges of a layer's boundary, by vertex.

/// Boundary edges: those with a triangle on one side only.
pub(super) struct Rims {
    /// Edges, those of each vertex together: both ends know an edge.
    edges: Vec<[u32; 2]>,
    /// Where those of each vertex start, and the end.
    starts: Vec<u32>,
}

impl Rims {
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        let mut sorted: Vec<[u32; 2]> = triangles.iter().flat_map(sides).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        sorted.sort_unstable();
        let mut edges = Vec::new();
        for run in sorted.chunk_by(|one, other| one == other) {
            if let [[a, b]] = *run {
                edges.extend([[a, b], [b, a]]);
            }
        }
        edges.sort_unstable();
        let mut starts = vec![0; vertices + 1];
        edges.iter().for_each(|edge| starts[edge[0] as usize + 1] += 1);
        (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
        Rims { edges, starts }
    }

    /// The boundary edges that end at a corner of a triangle, each once.
    pub fn near(&self, corners: &[u32; 3]) -> Vec<[u32; 2]> {
        let of = |v: u32| &self.edges[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize];
        let mut near: Vec<[u32; 2]> = corners.iter().flat_map(|&v| of(v)).map(|&[a, b]| [a.min(b), a.max(b)]).collect();
        near.sort_unstable();
        near.dedup();
        near
    }
}
