//! Where a surface ends: edges that its triangles do not pass through equally often in both directions.
//!
//! If there are none, the triangles form a cycle: the winding number is then a whole number off the surface, and the
//! same all over every connected set that the surface misses, however the triangles pass through each other.
//! Vertices are the same if their positions are.
//!
//! If there are some, they form closed loops (a boundary has none of its own). A cone over each loop, from the mean of
//! its edges, turned against the surface, closes it: the cap of a plane hole is that hole filled.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// For each vertex the first one at its position.
pub(crate) fn welded(vertices: &[Point3<f64>]) -> Vec<u32> {
    // Only looked up, never walked through: the order of the map does not matter. Adding zero takes -0 to 0.
    let mut by_place = HashMap::with_capacity(vertices.len());
    let first = |(index, at): (u32, &Point3<f64>)| {
        *by_place.entry([0, 1, 2].map(|axis| (at[axis] + 0.0).to_bits())).or_insert(index)
    };
    (0..).zip(vertices).map(first).collect()
}

/// An edge that the triangles pass through more often from its first vertex to the second than back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OpenEdge {
    pub(crate) ends: [u32; 2],
    pub(crate) surplus: u32,
}

/// What closes a loop of open edges.
#[derive(Clone, Debug)]
pub(crate) struct Cap {
    pub(crate) apex: Point3<f64>,
    /// Its triangles but for the apex, which comes first in each.
    pub(crate) edges: Vec<[u32; 2]>,
    /// Farthest that it reaches from the apex, and its area.
    pub(crate) radius: f64,
    pub(crate) area: f64,
}

/// The caps of a surface with these open edges.
pub(crate) fn caps(vertices: &[Point3<f64>], open: &[OpenEdge]) -> Vec<Cap> {
    let mut loops: Vec<u32> = (0..open.len() as u32).collect();
    let mut at_vertex = HashMap::new();
    for (index, edge) in (0..).zip(open) {
        for end in edge.ends {
            let other = *at_vertex.entry(end).or_insert(index);
            let (a, b) = (root(&mut loops, index), root(&mut loops, other));
            loops[a.max(b) as usize] = a.min(b);
        }
    }
    let mut edges: Vec<(u32, OpenEdge)> = (0..).zip(open).map(|(at, edge)| (root(&mut loops, at), *edge)).collect();
    edges.sort_by_key(|edge| edge.0);
    let place = |vertex: u32| vertices[vertex as usize];
    let cap = |edges: &[(u32, OpenEdge)]| {
        let ends = edges.iter().flat_map(|(_, edge)| edge.ends);
        let sum = ends.clone().map(|end| place(end).coords).sum::<Vector3<f64>>();
        let apex = Point3::from(sum / (2 * edges.len()) as f64);
        let against = |(_, edge): &(u32, OpenEdge)| {
            let [a, b] = edge.ends;
            std::iter::repeat_n([b, a], edge.surplus as usize)
        };
        let edges: Vec<_> = edges.iter().flat_map(against).collect();
        let area = |&[a, b]: &[u32; 2]| (place(a) - apex).cross(&(place(b) - apex)).norm() / 2.0;
        let radius = ends.map(|end| (place(end) - apex).norm()).fold(0.0, f64::max);
        Cap { apex, area: edges.iter().map(area).sum(), edges, radius }
    };
    edges.chunk_by(|a, b| a.0 == b.0).map(cap).collect()
}

fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}

/// The open edges of a surface of welded vertices, by rising lower and then higher end.
///
/// `O(n)` but for the sorting of the few edges that share a vertex.
pub(crate) fn open_edges(welded: &[u32], triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Vec<OpenEdge> {
    let edges = triangles.flat_map(|corners| sides(corners.map(|corner| welded[corner as usize])));
    let edges = edges.filter(|[from, to]| from != to);

    let mut ends = vec![0; welded.len() + 1];
    for [a, b] in edges.clone() {
        ends[a.min(b) as usize + 1] += 1;
    }
    for at in 1..ends.len() {
        ends[at] += ends[at - 1];
    }
    let mut others = vec![(0, 0); ends.last().copied().unwrap_or(0)];
    for [a, b] in edges {
        let next = &mut ends[a.min(b) as usize];
        others[*next] = (a.max(b), if a < b { 1 } else { -1 });
        *next += 1;
    }

    // Each end has become the end of its own corner.
    let (mut open, mut first) = (Vec::new(), 0);
    for (corner, &end) in (0..).zip(&ends[..welded.len()]) {
        others[first..end].sort_unstable();
        for edge in others[first..end].chunk_by(|a, b| a.0 == b.0) {
            match edge.iter().map(|&(_, way)| way).sum::<i32>() {
                0 => {}
                surplus => open.push(OpenEdge {
                    ends: if surplus > 0 { [corner, edge[0].0] } else { [edge[0].0, corner] },
                    surplus: surplus.unsigned_abs(),
                }),
            }
        }
        first = end;
    }
    open
}

/// The directed edges of a triangle.
pub(crate) fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_closed_until_a_face_is_missing_or_turned() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-0.0, -0.0, 0.0]];
        let welded = welded(&corners.map(Point3::from));
        let faces = [[0, 2, 1], [0, 1, 3], [4, 3, 2], [1, 2, 3]];
        let ends = |edges: Vec<OpenEdge>| edges.iter().map(|edge| edge.ends).collect::<Vec<_>>();
        assert_eq!(open_edges(&welded, faces.into_iter()), []);
        assert_eq!(ends(open_edges(&welded, faces.into_iter().skip(1))), [[0, 1], [2, 0], [1, 2]]);
        let turned = faces.map(|f| if f == [1, 2, 3] { [2, 1, 3] } else { f });
        let open = open_edges(&welded, turned.into_iter());
        assert_eq!(ends(open.clone()), [[2, 1], [1, 3], [3, 2]]);
        assert!(open.iter().all(|edge| edge.surplus == 2));
    }

    #[test]
    fn caps_close_each_loop_for_itself() {
        // Two squares without edges in common, one of them twice.
        let corners = |z: f64| [[0.0, 0.0, z], [2.0, 0.0, z], [2.0, 2.0, z], [0.0, 2.0, z]].map(Point3::from);
        let vertices = [corners(0.0), corners(5.0)].concat();
        let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [4, 5, 6], [4, 6, 7]];
        let caps = caps(&vertices, &open_edges(&welded(&vertices), faces.into_iter()));
        assert_eq!(caps.len(), 2);
        for (cap, (z, area)) in caps.iter().zip([(0.0, 4.0), (5.0, 8.0)]) {
            assert_eq!(cap.apex, Point3::new(1.0, 1.0, z));
            assert_eq!((cap.area, cap.radius), (area, 2f64.sqrt()));
            let side = |vertex: u32| vertices[vertex as usize] - cap.apex;
            assert!(cap.edges.iter().all(|&[a, b]| side(a).cross(&side(b)).z < 0.0));
        }
    }
}
