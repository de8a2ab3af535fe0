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
        let mut surface = Contracting::new(vertices.len(), triangles);
        surface.contract_all(short);
        triangles = surface.left();
    }
    used_alone(&vertices, triangles)
}

/// A surface of which edges are contracted.
struct Contracting {
    triangles: Vec<[u32; 3]>,
    /// Whether a triangle is still there. The corners of those that are have not gone.
    alive: Vec<bool>,
    /// The triangles at a vertex that has not gone, with some that are not there any more.
    faces_at: Vec<Vec<usize>>,
    /// The vertex that took a vertex's place: itself while it has not gone.
    kept: Vec<u32>,
}

impl Contracting {
    fn new(vertices: usize, triangles: Vec<[u32; 3]>) -> Self {
        let mut faces_at: Vec<Vec<usize>> = vec![Vec::new(); vertices];
        for (face, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| faces_at[v as usize].push(face));
        }
        let alive = vec![true; triangles.len()];
        Contracting { triangles, alive, faces_at, kept: (0..vertices as u32).collect() }
    }

    /// Contracts edges. A contraction may free another one: around again while something changes.
    fn contract_all(&mut self, mut waiting: Vec<[u32; 2]>) {
        loop {
            let before = waiting.len();
            waiting.retain(|&[a, b]| !self.contract(a, b));
            if waiting.len() == before || waiting.is_empty() {
                break;
            }
        }
    }

    /// Contracts an edge unless that would change the topology; true if it is gone then, by this or by a contraction before.
    fn contract(&mut self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|v| self.now(v));
        if a == b {
            return true;
        }
        let (around_a, around_b) = (self.ring(a), self.ring(b));
        let common = around_a.intersection(&around_b).count();
        let shared: Vec<usize> = self.at(b).filter(|&face| self.triangles[face].contains(&a)).collect();
        // A tetrahedron has four corners.
        if common != 2 || shared.len() != 2 || around_a.union(&around_b).count() <= 4 {
            return false;
        }
        shared.iter().for_each(|&face| self.alive[face] = false);
        let moved = std::mem::take(&mut self.faces_at[b as usize]);
        for face in moved.into_iter().filter(|&face| self.alive[face]) {
            self.triangles[face] = self.triangles[face].map(|v| if v == b { a } else { v });
            self.faces_at[a as usize].push(face);
        }
        self.kept[b as usize] = a;
        true
    }

    /// Where a vertex went: what took its place may have gone as well.
    fn now(&self, mut v: u32) -> u32 {
        while self.kept[v as usize] != v {
            v = self.kept[v as usize];
        }
        v
    }

    fn at(&self, v: u32) -> impl Iterator<Item = usize> {
        self.faces_at[v as usize].iter().copied().filter(|&face| self.alive[face])
    }

    /// The neighbours of a vertex.
    fn ring(&self, v: u32) -> BTreeSet<u32> {
        self.at(v).flat_map(|face| self.triangles[face]).filter(|&w| w != v).collect()
    }

    fn left(self) -> Vec<[u32; 3]> {
        let there = self.triangles.into_iter().zip(self.alive).filter(|(_, alive)| *alive);
        there.map(|(triangle, _)| triangle).collect()
    }
}

/// The vertices that triangles use, numbered as they come.
fn used_alone(vertices: &[Point3<f64>], mut triangles: Vec<[u32; 3]>) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
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
