//! A solid in cells that share their walls: cut by planes, merged again, closed by construction.
//!
//! All cells share one set of vertices. A face lies between two cells, or between a cell and the outside; a cut adds a
//! vertex on each edge that it crosses, splits the faces on both sides of it, and closes both halves with the same triangles.
//! Two cells that are merged lose the faces between them. So cells always fit without gaps and need no welding, whatever
//! rounding does to the place of a vertex, and polyhedral walls are several cuts and a merge.
//!
//! Vertices in the plane count as above or below it, by a rule that leaves no sheets without thickness: those of a face in the
//! plane are on the side of the solid behind that face, others are above if a neighbour is. Any choice would be consistent: the
//! topology comes from these signs alone (simulation of simplicity), which are exact.

use super::cap::triangulate;
use super::mesh::{Solid, SolidError, doubled_normal, signed_volume, winding_of};
use super::plane::{CutPlane, PlaneFrame};
use super::tidy::tidied;
use crate::union_find::UnionFind;
use nalgebra::{Point2, Point3};
use std::collections::{BTreeMap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};

/// The outside of the solid, where a face names a cell.
const OUTSIDE: u32 = u32::MAX;

/// A triangle between two cells; its normal points from `back` to `front`.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [u32; 3],
    back: u32,
    front: u32,
}

/// A solid in cells. Cells have numbers; one that is cut is replaced by new ones.
#[derive(Clone, Debug)]
pub struct Partition {
    points: Vec<Point3<f64>>,
    faces: Vec<Face>,
    cells: u32,
}

/// A triangle around a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    /// Numbers of its corners in the partition, counter-clockwise from outside the cell.
    pub(crate) corners: [u32; 3],
    /// Where they are.
    pub(crate) places: [Point3<f64>; 3],
    /// The cell on the other side; none where that is the outside of the solid.
    pub(crate) beyond: Option<u32>,
}

/// What a cut makes of the cells that it was asked to cut.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cut {
    /// The connected pieces above the plane.
    pub above: Vec<u32>,
    /// The connected pieces below the plane.
    pub below: Vec<u32>,
}

/// Maps of edges: their vertices, mixed by a multiplication. No map is ever walked, so that the order in it is of no account.
type EdgeMap<T> = HashMap<[u32; 2], T, BuildHasherDefault<EdgeHasher>>;

#[derive(Default)]
struct EdgeHasher(u64);

impl Hasher for EdgeHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for eight in bytes.chunks(8) {
            let word = eight.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
            // 2^64 over the golden ratio; the upper half goes back to where the map looks.
            let mixed = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            self.0 = mixed ^ mixed >> 32;
        }
    }
}

/// A piece smaller than this share of the volume of its bounding box is a sliver of rounding: it stays with the largest
/// piece on its side.
const DUST: f64 = 1e-12;

/// The point where the edge between two vertices on different sides meets the plane; the caller names them in one order.
pub(super) fn cut_point(plane: &CutPlane, u: &Point3<f64>, v: &Point3<f64>) -> Point3<f64> {
    match (plane.side(u), plane.side(v)) {
        (0, _) => *u,
        (_, 0) => *v,
        _ => {
            let [hu, hv] = [plane.height(u), plane.height(v)];
            // Signs are exact, heights are rounded.
            let share = if hu - hv == 0.0 { 0.5 } else { (hu / (hu - hv)).clamp(0.0, 1.0) };
            u + (v - u) * share
        }
    }
}

impl Partition {
    /// A solid in one cell, number 0.
    pub fn new(solid: &Solid) -> Self {
        let face = |&corners: &[u32; 3]| Face { corners, back: 0, front: OUTSIDE };
        Partition { points: solid.vertices().to_vec(), faces: solid.triangles().iter().map(face).collect(), cells: 1 }
    }

    /// Cuts cells along a plane.
    ///
    /// # Returns
    /// The pieces, each connected, by the order of the cells. Cells that the plane misses are renamed as well. Other cells only get
    /// vertices where they share an edge that is cut.
    ///
    /// # Cost
    /// `O(n log n)` for the `n` triangles of the partition, and the square of the corners of a section.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// use curvlay_layers::planar::{CutPlane, Partition, Solid};
    /// let tetrahedron = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Into::into);
    /// let solid = Solid::new(&tetrahedron, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// let mut partition = Partition::new(&solid);
    /// let plane = CutPlane::through(&Point3::new(0.0, 0.0, 1.0), &Vector3::z())?;
    /// let cut = partition.cut(&[0], &plane);
    /// let tip = partition.part(cut.above[0])?;
    /// assert!((tip.volume() - solid.volume() / 8.0).abs() < 1e-15);
    /// assert_eq!((cut.above.len(), cut.below.len(), tip.triangles().len()), (1, 1, 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cut(&mut self, cells: &[u32], plane: &CutPlane) -> Cut {
        let is_cut = |cell: u32| cells.contains(&cell);
        let active: Vec<bool> = self.faces.iter().map(|face| is_cut(face.back) || is_cut(face.front)).collect();
        let above = self.sides(&active, plane, is_cut);
        let sides = self.split(&active, plane, &above);
        let mut cut = Cut::default();
        // Faces of before, split; caps come behind them.
        for &cell in cells {
            let caps = self.close(cell, plane, &sides);
            for side in [true, false] {
                let of_side = |&(face, _): &(usize, bool)| face >= sides.len() || sides[face].0 == side;
                let mut own: Vec<(usize, bool)> = self.faces_of(cell).into_iter().filter(of_side).collect();
                own.extend(caps.clone().map(|face| (face, side)));
                let new = self.name_pieces(&own);
                if side { cut.above.extend(new) } else { cut.below.extend(new) }
            }
        }
        cut
    }

    /// Gives the cell `other` to the cell `cell`; faces between them go. They need not touch.
    pub fn merge(&mut self, cell: u32, other: u32) {
        for face in &mut self.faces {
            for side in [&mut face.back, &mut face.front] {
                if *side == other {
                    *side = cell;
                }
            }
        }
        self.faces.retain(|face| face.back != face.front);
    }

    /// The solid of a cell, with its own vertices; edges without length are contracted.
    ///
    /// # Errors
    /// [`SolidError::Empty`] for a number that no cell has; [`SolidError::NotManifold`] for a cell that touches itself along an
    /// edge, which only [`Partition::merge`] can bring about.
    pub fn part(&self, cell: u32) -> Result<Solid, SolidError> {
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for (face, turned) in self.faces_of(cell) {
            let [a, b, c] = self.faces[face].corners;
            let corners = if turned { [a, c, b] } else { [a, b, c] };
            triangles.push(corners.map(|v| {
                *number.entry(v).or_insert_with(|| {
                    vertices.push(self.points[v as usize]);
                    vertices.len() as u32 - 1
                })
            }));
        }
        if triangles.is_empty() {
            return Err(SolidError::Empty);
        }
        let (vertices, triangles) = tidied(vertices, triangles);
        Solid::with_edges(vertices, triangles)
    }

    /// Some cells without the others: the faces around them, which still name the cells beyond. What a cut makes of a cell here it makes of
    /// it in the whole, with the same numbers.
    pub(crate) fn only(&self, cells: &[u32]) -> Self {
        let is_own = |cell: u32| cells.contains(&cell);
        let mut faces: Vec<Face> =
            self.faces.iter().filter(|face| is_own(face.back) || is_own(face.front)).copied().collect();
        let mut number = vec![u32::MAX; self.points.len()];
        faces.iter().flat_map(|face| face.corners).for_each(|v| number[v as usize] = 0);
        let mut points = Vec::new();
        // In the same order, since a cut goes from the lower to the higher number along an edge.
        for (number, point) in number.iter_mut().zip(&self.points).filter(|(number, _)| **number == 0) {
            *number = points.len() as u32;
            points.push(*point);
        }
        faces.iter_mut().flat_map(|face| &mut face.corners).for_each(|v| *v = number[*v as usize]);
        Partition { points, faces, cells: self.cells }
    }

    /// The volume of a cell; 0 for a number that no cell has.
    pub fn volume(&self, cell: u32) -> f64 {
        self.volume_of(&self.faces_of(cell))
    }

    /// The area of the faces between two cells.
    pub fn shared_area(&self, cell: u32, other: u32) -> f64 {
        let between =
            |face: &&Face| (face.back, face.front) == (cell, other) || (face.back, face.front) == (other, cell);
        self.faces.iter().filter(between).map(|face| doubled_normal(self.places(face.corners)).norm() / 2.0).sum()
    }

    /// The triangles around a cell.
    ///
    /// # Cost
    /// `O(n)` for the `n` triangles of the partition.
    pub(crate) fn walls(&self, cell: u32) -> Vec<Wall> {
        let wall = |side: (usize, bool)| {
            let face = &self.faces[side.0];
            let [a, b, c] = face.corners;
            let (corners, beyond) = if side.1 { ([a, c, b], face.back) } else { ([a, b, c], face.front) };
            Wall { corners, places: self.places(corners), beyond: (beyond != OUTSIDE).then_some(beyond) }
        };
        self.faces_of(cell).into_iter().map(wall).collect()
    }

    /// The corners of the faces between two cells; some come more than once.
    pub fn shared_points(&self, cell: u32, other: u32) -> Vec<Point3<f64>> {
        let between =
            |face: &&Face| (face.back, face.front) == (cell, other) || (face.back, face.front) == (other, cell);
        self.faces.iter().filter(between).flat_map(|face| self.places(face.corners)).collect()
    }

    /// Cells in order of their numbers.
    pub fn cells(&self) -> Vec<u32> {
        let mut all: Vec<u32> = self.faces.iter().flat_map(|face| [face.back, face.front]).collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|&cell| cell != OUTSIDE);
        all
    }

    /// Whether a point is inside a cell, by its winding number.
    pub fn contains(&self, cell: u32, p: &Point3<f64>) -> bool {
        let faces = self.faces_of(cell);
        winding_of(faces.iter().map(|&side| self.places_seen(side)), p) > 0.5
    }

    /// The faces of a cell, and whether they are turned: seen from inside the other way round.
    fn faces_of(&self, cell: u32) -> Vec<(usize, bool)> {
        let side = |(index, face): (usize, &Face)| match (face.back == cell, face.front == cell) {
            (true, _) => Some((index, false)),
            (_, true) => Some((index, true)),
            _ => None,
        };
        self.faces.iter().enumerate().filter_map(side).collect()
    }

    fn places(&self, corners: [u32; 3]) -> [Point3<f64>; 3] {
        corners.map(|v| self.points[v as usize])
    }

    /// The corners of a face, counter-clockwise from outside its cell.
    fn places_seen(&self, (face, turned): (usize, bool)) -> [Point3<f64>; 3] {
        let [a, b, c] = self.places(self.faces[face].corners);
        if turned { [a, c, b] } else { [a, b, c] }
    }

    fn volume_of(&self, faces: &[(usize, bool)]) -> f64 {
        let Some(&(first, _)) = faces.first() else { return 0.0 };
        let from = self.points[self.faces[first].corners[0] as usize];
        signed_volume(from, faces.iter().map(|&side| self.places_seen(side)))
    }

    /// Which vertices are above the plane; of those on it, by the rule in the head of this file.
    fn sides(&self, active: &[bool], plane: &CutPlane, is_cut: impl Fn(u32) -> bool) -> Vec<bool> {
        let mut side = vec![0_i8; self.points.len()];
        let mut known = vec![false; self.points.len()];
        let faces = || self.faces.iter().zip(active).filter(|(_, active)| **active).map(|(face, _)| face);
        for v in faces().flat_map(|face| face.corners.map(|v| v as usize)) {
            if !known[v] {
                (known[v], side[v]) = (true, plane.side(&self.points[v]));
            }
        }
        let exact = side.clone();
        for face in faces().filter(|face| face.corners.iter().all(|&v| exact[v as usize] == 0)) {
            let out = match (is_cut(face.back), is_cut(face.front)) {
                (true, true) => continue,
                (_, turned) => {
                    doubled_normal(self.places(face.corners)).dot(&plane.normal()) * if turned { -1.0 } else { 1.0 }
                }
            };
            // The solid is below a face that looks up.
            for v in face.corners.map(|v| v as usize).into_iter().filter(|_| out != 0.0) {
                side[v] = if out < 0.0 || side[v] > 0 { 1 } else { -1 };
            }
        }
        let decided = side.clone();
        for face in faces() {
            for k in 0..3 {
                let [v, a, b] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| face.corners[k] as usize);
                if decided[v] == 0 && (exact[a] > 0 || exact[b] > 0) {
                    side[v] = 1;
                }
            }
        }
        side.into_iter().map(|side| side > 0).collect()
    }

    /// Splits all faces with a crossed edge. Returns for each face whether it is above, and the line where it was split: from
    /// and to, with what is below to its left, seen from above and from the back of the face.
    fn split(&mut self, active: &[bool], plane: &CutPlane, above: &[bool]) -> Vec<(bool, Option<[u32; 2]>)> {
        let mut on_edge: EdgeMap<u32> = EdgeMap::default();
        let key = |a: u32, b: u32| [a.min(b), a.max(b)];
        for (face, _) in self.faces.iter().zip(active).filter(|(_, active)| **active) {
            for k in 0..3 {
                let [u, v] = key(face.corners[k], face.corners[(k + 1) % 3]);
                if above[u as usize] != above[v as usize] {
                    let next = self.points.len() as u32;
                    if let std::collections::hash_map::Entry::Vacant(new) = on_edge.entry([u, v]) {
                        new.insert(next);
                        let point = cut_point(plane, &self.points[u as usize], &self.points[v as usize]);
                        self.points.push(point);
                    }
                }
            }
        }
        let mut faces = Vec::with_capacity(self.faces.len() + on_edge.len() * 2);
        let mut sides = Vec::with_capacity(faces.capacity());
        for (face, &active) in self.faces.iter().zip(active) {
            let mut push = |corners: [u32; 3], up: bool, line: Option<[u32; 2]>| {
                faces.push(Face { corners, ..*face });
                sides.push((up, line));
            };
            // Vertices of faces that are not cut are all below, but for those that they share with one that is.
            let cut = [0, 1, 2].map(|k| {
                let [u, v] = key(face.corners[k], face.corners[(k + 1) % 3]);
                if above[u as usize] == above[v as usize] { None } else { on_edge.get(&[u, v]).copied() }
            });
            match cut.iter().flatten().count() {
                0 => push(face.corners, active && above[face.corners[0] as usize], None),
                1 => {
                    let k = (0..3).find(|&k| cut[k].is_some()).unwrap_or(0);
                    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| face.corners[k]);
                    let p = cut[k].unwrap_or(a);
                    push([a, p, c], false, None);
                    push([p, b, c], false, None);
                }
                _ => {
                    // The corner between both crossed edges.
                    let k = (0..3).find(|&k| cut[k].is_some() && cut[(k + 2) % 3].is_some()).unwrap_or(0);
                    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| face.corners[k]);
                    let (p, q) = (cut[k].unwrap_or(a), cut[(k + 2) % 3].unwrap_or(a));
                    let up = active && above[a as usize];
                    let line = active.then_some(if up { [p, q] } else { [q, p] });
                    push([a, p, q], up, line);
                    let place = |v: u32| self.points[v as usize];
                    // The shorter diagonal.
                    if (place(p) - place(c)).norm_squared() <= (place(q) - place(b)).norm_squared() {
                        push([p, b, c], active && !up, None);
                        push([p, c, q], active && !up, None);
                    } else {
                        push([p, b, q], active && !up, None);
                        push([b, c, q], active && !up, None);
                    }
                }
            }
        }
        self.faces = faces;
        sides
    }

    /// Adds the triangles that close the part of a cell below the plane. Returns their numbers.
    fn close(&mut self, cell: u32, plane: &CutPlane, sides: &[(bool, Option<[u32; 2]>)]) -> std::ops::Range<usize> {
        // More than one way on only where the cell touches itself along an edge; then any of them closes.
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (face, turned) in self.faces_of(cell) {
            if let Some([from, to]) = sides.get(face).and_then(|&(_, line)| line) {
                let (from, to) = if turned { (to, from) } else { (from, to) };
                next.entry(from).or_default().push(to);
            }
        }
        let starts: Vec<u32> = next.keys().copied().collect();
        let frame = PlaneFrame::of(plane);
        let mut loops: Vec<Vec<u32>> = Vec::new();
        for start in starts {
            loop {
                let mut points = Vec::new();
                let mut at = start;
                while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
                    points.push(at);
                    at = to;
                }
                if points.is_empty() {
                    break;
                }
                loops.push(points);
            }
        }
        let flat: Vec<Vec<Point2<f64>>> =
            loops.iter().map(|points| points.iter().map(|&v| frame.flat(&self.points[v as usize])).collect()).collect();
        let first = self.faces.len();
        // The back is below; the pieces are named by `name_pieces`.
        let cap = |corners| Face { corners, back: OUTSIDE, front: OUTSIDE };
        self.faces.extend(triangulate(&loops, &flat).into_iter().map(cap));
        first..self.faces.len()
    }

    /// Gives each connected piece among faces a new number. Shells around voids go with the piece that holds them.
    fn name_pieces(&mut self, faces: &[(usize, bool)]) -> Vec<u32> {
        let mut shells = self.shells(faces);
        let volumes: Vec<f64> = shells.iter().map(|shell| self.volume_of(shell)).collect();
        let size = |shell: &[(usize, bool)]| {
            let mut points = shell.iter().flat_map(|&(face, _)| self.places(self.faces[face].corners));
            let first = points.next().unwrap_or_else(Point3::origin);
            let [low, high] = points.fold([first, first], |[low, high], p| [low.inf(&p), high.sup(&p)]);
            (high - low).norm().powi(3)
        };
        let is_piece: Vec<bool> =
            shells.iter().zip(&volumes).map(|(shell, &volume)| volume > DUST * size(shell)).collect();
        let pieces: Vec<usize> = (0..shells.len()).filter(|&k| is_piece[k]).collect();
        let Some(&largest) = pieces.iter().max_by(|&&a, &&b| volumes[a].total_cmp(&volumes[b])) else {
            // Nothing but dust: one piece, so that nothing is lost.
            let all = shells.concat();
            return if all.is_empty() { Vec::new() } else { vec![self.name(&all)] };
        };
        for k in (0..shells.len()).filter(|&k| !is_piece[k]) {
            let shell = std::mem::take(&mut shells[k]);
            let p = self.points[self.faces[shell[0].0].corners[0] as usize];
            let holds = |&piece: &usize| winding_of(shells[piece].iter().map(|&side| self.places_seen(side)), &p) > 0.5;
            let around = pieces.iter().copied().filter(|&piece| volumes[piece] > -volumes[k]);
            let around = around.filter(holds).min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]));
            shells[around.unwrap_or(largest)].extend(shell);
        }
        pieces.into_iter().map(|piece| self.name(&shells[piece])).collect()
    }

    fn name(&mut self, faces: &[(usize, bool)]) -> u32 {
        let cell = self.cells;
        self.cells += 1;
        for &(face, turned) in faces {
            let face = &mut self.faces[face];
            if turned { face.front = cell } else { face.back = cell }
        }
        cell
    }

    /// Faces in groups that are connected over edges, by their first face.
    fn shells(&self, faces: &[(usize, bool)]) -> Vec<Vec<(usize, bool)>> {
        let mut groups = UnionFind::new(faces.len());
        let mut first_at: EdgeMap<usize> = EdgeMap::with_capacity_and_hasher(faces.len() * 2, Default::default());
        for (k, &(face, _)) in faces.iter().enumerate() {
            let corners = self.faces[face].corners;
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let other = *first_at.entry([a.min(b), a.max(b)]).or_insert(k);
                groups.join(k as u32, other as u32);
            }
        }
        let mut shells: BTreeMap<u32, Vec<(usize, bool)>> = BTreeMap::new();
        for (k, &side) in faces.iter().enumerate() {
            shells.entry(groups.root(k as u32)).or_default().push(side);
        }
        shells.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_cell_alone_is_cut_as_in_the_whole() {
        let points: Vec<Point3<f64>> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from).into()).collect();
        let mut whole = Partition::new(&Solid::new(&points, &crate::planar::solid::BOX).unwrap());
        let plane = |k: f64| {
            let normal = Vector3::new((k * 1.7).sin(), (k * 2.9).cos(), (k * 0.7).sin() + 0.2);
            CutPlane::through(&Point3::new(0.5, 0.4 + 0.02 * k, 0.5), &normal).unwrap()
        };
        for k in 0..12 {
            let cells = whole.cells();
            let cell = cells[k * 5 % cells.len()];
            let mut alone = whole.only(&[cell]);
            let next = plane(k as f64);
            let cut = whole.cut(&[cell], &next);
            assert_eq!(alone.cut(&[cell], &next), cut);
            for piece in cut.above.into_iter().chain(cut.below) {
                let [of_whole, of_alone] = [&whole, &alone].map(|partition| partition.walls(piece));
                let seen =
                    |walls: Vec<Wall>| walls.into_iter().map(|wall| (wall.places, wall.beyond)).collect::<Vec<_>>();
                assert_eq!(seen(of_whole), seen(of_alone));
            }
        }
        assert!(whole.cells().len() > 8);
    }
}
