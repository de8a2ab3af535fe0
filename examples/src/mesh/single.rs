//! Meshes in single precision, as STL has them: rounding must neither open a mesh nor leave triangles without area.
//!
//! Readers of STL join corners by their place. So corners that rounding makes equal become one, or that it leaves a rounding apart along an
//! edge, and a triangle of which two corners are one goes: its other two edges are one edge in both directions, so the mesh stays closed. A
//! triangle whose three corners come to lie on a line goes by an edge flip: its middle corner splits the neighbour across its longest edge. Two
//! triangles with the same corners and opposite windings enclose nothing, and go together.

use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Triangles in single precision.
pub(super) struct SingleMesh {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Rounds a mesh.
///
/// # Returns
/// Every corner at its nearest place in single precision, or a rounding beside it, each place once. Where the mesh is closed, so is the
/// result: over each edge as many triangles run one way as the other. No triangle has three corners on a line; one that is lower than a
/// rounding is left only where a flip leads to others like it.
///
/// # Cost
/// `O(n log n)` for `n` triangles.
pub(super) fn rounded(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> SingleMesh {
    let mut at_place: HashMap<[u32; 3], u32> = HashMap::with_capacity(vertices.len());
    let mut places: Vec<[f32; 3]> = Vec::new();
    let number: Vec<u32> = vertices
        .iter()
        .map(|p| {
            // Adding zero makes -0 and 0 one place.
            let place = [p.x, p.y, p.z].map(|c| c as f32 + 0.0);
            *at_place.entry(place.map(f32::to_bits)).or_insert_with(|| {
                places.push(place);
                places.len() as u32 - 1
            })
        })
        .collect();
    let largest = places.iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    let rounding = f64::from(largest) * f64::from(f32::EPSILON);
    let corners = |&[a, b, c]: &[u32; 3]| [a, b, c].map(|v| number[v as usize]);
    let triangles: Vec<[u32; 3]> = triangles.iter().map(corners).collect();
    let joined = without_short_edges(&places, &triangles, rounding);
    let mut flips = Flips { places, triangles: Vec::new(), along: HashMap::new(), flat: BTreeMap::new(), rounding };
    triangles.iter().for_each(|corners| flips.add(corners.map(|v| joined[v as usize])));
    flips.run();
    // What a flip of a low triangle could not better may still be on a line: then it can.
    flips.rounding = 0.0;
    flips.find_flat();
    flips.run();
    SingleMesh { vertices: flips.places, triangles: flips.triangles.into_iter().flatten().collect() }
}

/// For each vertex the one it becomes: edges shorter than a rounding have their ends at one of them. No vertex moves by more.
fn without_short_edges(places: &[[f32; 3]], triangles: &[[u32; 3]], rounding: f64) -> Vec<u32> {
    let mut joined: Vec<u32> = (0..places.len() as u32).collect();
    let mut is_kept = vec![false; places.len()];
    for [a, b] in triangles.iter().flat_map(|&corners| edges(corners)) {
        let [kept, moved] = [joined[a as usize], joined[b as usize]];
        let [p, q] = [kept, b].map(|v| Vector3::from(places[v as usize].map(f64::from)));
        // Only what has not moved yet, and what nothing was moved to.
        if kept != moved && moved == b && !is_kept[b as usize] && (p - q).norm() <= rounding {
            joined[b as usize] = kept;
            is_kept[kept as usize] = true;
        }
    }
    joined
}

/// A mesh on its way to one whose triangles all have an area.
struct Flips {
    places: Vec<[f32; 3]>,
    /// None where a triangle went.
    triangles: Vec<Option<[u32; 3]>>,
    /// The triangles that run along an edge in this direction.
    along: HashMap<[u32; 2], Vec<usize>>,
    /// Triangles without area, by their longest edge: the longest comes first, so that every flip leaves shorter ones.
    flat: BTreeMap<u64, BTreeSet<usize>>,
    /// A triangle that is not higher than this is flat.
    rounding: f64,
}

impl Flips {
    fn place(&self, v: u32) -> Vector3<f64> {
        Vector3::from(self.places[v as usize].map(f64::from))
    }

    /// The corner across the longest edge, and the square of the length of that.
    fn longest(&self, corners: [u32; 3]) -> (usize, f64) {
        let length = |k: usize| (self.place(corners[(k + 1) % 3]) - self.place(corners[(k + 2) % 3])).norm_squared();
        let squares = [0, 1, 2].map(length);
        let k = (1..3).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
        (k, squares[k])
    }

    /// The square of the longest edge of a triangle without area.
    fn flat_edge(&self, corners: [u32; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|v| self.place(v));
        let (_, squared) = self.longest(corners);
        ((b - a).cross(&(c - a)).norm() <= self.rounding * squared.sqrt()).then_some(squared)
    }

    fn find_flat(&mut self) {
        for (number, corners) in self.triangles.iter().enumerate() {
            if let Some(squared) = corners.and_then(|corners| self.flat_edge(corners)) {
                self.flat.entry(squared.to_bits()).or_default().insert(number);
            }
        }
    }

    /// Adds a triangle, unless it has a corner twice or its opposite is there, which then goes as well.
    fn add(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            return;
        }
        let is_opposite = |&&other: &&usize| self.triangles[other].is_some_and(|corners| corners.contains(&c));
        if let Some(&other) = self.along.get(&[b, a]).and_then(|there| there.iter().find(is_opposite)) {
            self.remove(other);
            return;
        }
        let number = self.triangles.len();
        self.triangles.push(Some(corners));
        for edge in edges(corners) {
            self.along.entry(edge).or_default().push(number);
        }
        if let Some(squared) = self.flat_edge(corners) {
            // Squares are positive: their bits are in their order.
            self.flat.entry(squared.to_bits()).or_default().insert(number);
        }
    }

    fn remove(&mut self, number: usize) {
        let Some(corners) = self.triangles[number].take() else { return };
        for edge in edges(corners) {
            if let Some(there) = self.along.get_mut(&edge) {
                there.retain(|&other| other != number);
            }
        }
        self.forget(number, self.longest(corners).1);
    }

    /// Takes a triangle out of the list of those without area.
    fn forget(&mut self, number: usize, squared: f64) {
        if let Some(alike) = self.flat.get_mut(&squared.to_bits()) {
            alike.remove(&number);
            if alike.is_empty() {
                self.flat.remove(&squared.to_bits());
            }
        }
    }

    /// Flips until no triangle without area is left that a flip betters: each flip leaves only such with shorter edges, so it ends.
    fn run(&mut self) {
        while let Some((&bits, alike)) = self.flat.last_key_value() {
            let Some((&number, corners)) = alike.first().and_then(|number| Some((number, self.triangles[*number]?)))
            else {
                self.flat.remove(&bits);
                continue;
            };
            let (k, squared) = self.longest(corners);
            let [b, c, a] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| corners[k]);
            let across = self.along.get(&[a, c]).and_then(|there| there.first()).copied();
            let Some((neighbour, of)) = across.and_then(|across| Some((across, self.triangles[across]?))) else {
                // An open edge: there is nothing to split.
                self.remove(number);
                continue;
            };
            let d = of.into_iter().find(|&v| v != a && v != c).unwrap_or(b);
            let split = [[a, b, d], [b, c, d]];
            let betters = |corners: [u32; 3]| self.flat_edge(corners).is_none_or(|of_split| of_split < squared);
            if b == d || split.into_iter().all(betters) {
                self.remove(number);
                self.remove(neighbour);
                split.into_iter().for_each(|corners| self.add(corners));
            } else {
                self.forget(number, squared);
            }
        }
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
