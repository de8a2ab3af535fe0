//! Edges without length go, as long as the surface stays a manifold.

use nalgebra::Point3;
use std::collections::BTreeSet;

/// Contracts edges whose ends are at the same place, and drops vertices that no triangle uses.
///
/// An edge goes only if its ends have just the two neighbours in common that its faces name (the link condition of T. K. Dey et
/// al., "Topology preserving edge contraction", Publ. Inst. Math. 66, 1999), and if it is not of a tetrahedron: so the surface
/// keeps its topology. Edges for which that fails stay.
pub(super) fn tidied(vertices: Vec<Point3<f64>>, mut triangles: Vec<[u32; 3]>) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let is_short = |a: u32, b: u32| vertices[a as usize] == vertices[b as usize];
    let short: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|&[a, b]| a < b && is_short(a, b))
        .collect();
    if !short.is_empty() {
        let mut faces_at: Vec<Vec<usize>> = vec![Vec::new(); vertices.len()];
        for (face, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| faces_at[v as usize].push(face));
        }
        let mut alive = vec![true; triangles.len()];
        // Where a vertex went.
        let mut kept: Vec<u32> = (0..vertices.len() as u32).collect();
        let mut waiting: Vec<[u32; 2]> = short;
        // A contraction may free another one: around again while something changes.
        loop {
            let before = waiting.len();
            waiting.retain(|&[a, b]| {
                let [a, b] = [a, b].map(|v| {
                    let mut v = v;
                    while kept[v as usize] != v {
                        v = kept[v as usize];
                    }
                    v
                });
                if a == b {
                    return false;
                }
                let ring = |v: u32| -> BTreeSet<u32> {
                    let around = faces_at[v as usize].iter().filter(|&&face| alive[face]);
                    around.flat_map(|&face| triangles[face]).filter(|&w| w != v).collect()
                };
                let common = ring(a).intersection(&ring(b)).count();
                let shared: Vec<usize> = faces_at[b as usize]
                    .iter()
                    .copied()
                    .filter(|&face| alive[face] && triangles[face].contains(&a))
                    .collect();
                let size = ring(a).union(&ring(b)).count();
                // A tetrahedron has four corners.
                if common != 2 || shared.len() != 2 || size <= 4 {
                    return true;
                }
                shared.iter().for_each(|&face| alive[face] = false);
                let moved = std::mem::take(&mut faces_at[b as usize]);
                for face in moved.into_iter().filter(|&face| alive[face]) {
                    triangles[face] = triangles[face].map(|v| if v == b { a } else { v });
                    faces_at[a as usize].push(face);
                }
                kept[b as usize] = a;
                false
            });
            if waiting.len() == before || waiting.is_empty() {
                break;
            }
        }
        let mut index = 0..triangles.len();
        triangles.retain(|_| index.next().is_some_and(|face| alive[face]));
    }
    let mut number = vec![u32::MAX; vertices.len()];
    let mut used = Vec::new();
    for v in triangles.iter_mut().flatten() {
        let at = *v as usize;
        if number[at] == u32::MAX {
            number[at] = used.len() as u32;
            used.push(vertices[at]);
        }
        *v = number[at];
    }
    (used, triangles)
}
