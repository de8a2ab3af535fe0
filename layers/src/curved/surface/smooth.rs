//! Borders of surfaces as smooth lines.
//!
//! At a cut a surface ends on the faces of cells, so its border is a staircase where the cut is not along an axis. Here each vertex of
//! the border moves, a few rounds long, half the way to the line between its two neighbours on the border, as in Laplacian smoothing
//! (D. A. Field, "Laplacian smoothing and Delaunay triangulations", Comm. Appl. Numer. Methods 4, 1988). What is kept:
//! * A vertex slides in the plane of the surface where it was, at most [`BorderSmoothing::reach`] cells far, so that the surface stays
//!   at its level and covers what it covered but for that.
//! * It moves across its border only, not along it: a straight border stays as it is.
//! * No triangle turns by more than 60 degrees, or gets flatter than a twentieth of a cell and than it was: such a move is left out.
//! * All other vertices and all triangles stay. So the surface is the manifold that it was.
//!
//! Each side of a cut is smoothed by itself, so that the two may overlap or part by less than a cell in all. Surfaces are smoothed before they are trimmed and clipped: ends on the mesh are exact, and what passes through an earlier surface is cut.

use super::contour::Surface;
use nalgebra::{Point3, Vector3};

/// The share of the way to the line between its neighbours that a vertex moves in a round: less than all of it, since the neighbours move too.
const SHARE: f64 = 0.5;

/// Least cosine between the normals of a triangle before and after: 60 degrees.
const TURN: f64 = 0.5;

/// Least altitude of a triangle at a vertex that moves, in cells, unless it was less before.
const FLAT: f64 = 0.05;

/// Moves below this, in cells, count as none, so that rounding does not move a straight border.
const STILL: f64 = 1e-9;

/// What stands for no vertex.
const NONE: u32 = u32::MAX;

/// How borders are smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BorderSmoothing {
    /// Rounds: 10. Steps up to four cells long are smooth then; 0 leaves all as it is.
    pub rounds: u32,
    /// How far a vertex may move in all, in cells: 0.5, which is how far the steps of a staircase are off its line. Nothing moves for 0, or what is
    /// no length.
    pub reach: f64,
}

impl Default for BorderSmoothing {
    fn default() -> Self {
        BorderSmoothing { rounds: 10, reach: 0.5 }
    }
}

impl Surface {
    /// Smooths the border: vertices move along the surface, across the border, towards the line between their neighbours.
    ///
    /// # Arguments
    /// * `cell_mm`: the edge of a cell, in millimetres.
    ///
    /// A surface with triangles that name points that are not there stays as it is; so do vertices where more than one
    /// border passes.
    ///
    /// # Cost
    /// `O(n log n)` for `n` triangles, to find the border; some tenths of a microsecond for each of its vertices and each round.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::surface::{BorderSmoothing, Surface};
    /// use curvlay_layers::nalgebra::Point3;
    /// // Squares of 1 mm below a staircase: one, two and three of them.
    /// let squares = [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]];
    /// let corner = |k: u32| Point3::new(f64::from(k % 4), f64::from(k / 4), 0.0);
    /// let two = |[x, y]: [u32; 2]| [[0, 1, 5], [0, 5, 4]].map(|corners| corners.map(|c| x + 4 * y + c));
    /// let points = (0..16).map(corner).collect();
    /// let mut surface = Surface { value: 1.0, points, triangles: squares.into_iter().flat_map(two).collect() };
    /// surface.smooth_border(1.0, BorderSmoothing::default());
    /// // Corners of the staircase, one that turns right and one that turns left, come to lie on a line.
    /// let off_diagonal = |corner: usize| surface.points[corner].x - surface.points[corner].y;
    /// assert!((off_diagonal(1) - off_diagonal(5)).abs() < 0.01, "{} {}", off_diagonal(1), off_diagonal(5));
    /// ```
    pub fn smooth_border(&mut self, cell_mm: f64, smoothing: BorderSmoothing) {
        let reach = smoothing.reach * cell_mm;
        let sound = self.triangles.iter().flatten().all(|&corner| (corner as usize) < self.points.len());
        if !(sound && reach > 0.0 && reach.is_finite()) {
            return;
        }
        let border = Border::of(self);
        let before = self.points.clone();
        for _ in 0..smoothing.rounds {
            let wanted: Vec<Point3<f64>> =
                border.vertices.iter().map(|vertex| vertex.wanted(self, &before, reach)).collect();
            let mut moved = false;
            for (vertex, wanted) in border.vertices.iter().zip(wanted) {
                let place = self.points[vertex.number as usize];
                if (wanted - place).norm() > STILL * cell_mm {
                    moved |= vertex.move_to(self, wanted, &before, &border, FLAT * cell_mm);
                }
            }
            if !moved {
                break;
            }
        }
    }
}

/// The border of a surface.
struct Border {
    vertices: Vec<Vertex>,
    /// The triangles around each of them.
    stars: Vec<u32>,
}

/// A vertex of the border.
struct Vertex {
    number: u32,
    /// Those before and after it on the border.
    beside: [u32; 2],
    /// The normal of the surface there.
    normal: Vector3<f64>,
    /// Where its triangles are in [`Border::stars`].
    star: [usize; 2],
}

impl Border {
    fn of(surface: &Surface) -> Border {
        let Surface { points, triangles, .. } = surface;
        let mut halves: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        halves.sort_unstable();
        let mut beside = vec![[NONE; 2]; points.len()];
        let mut crossed = vec![false; points.len()];
        for &[from, to] in halves.iter().filter(|[from, to]| halves.binary_search(&[*to, *from]).is_err()) {
            for (vertex, side, other) in [(from, 1, to), (to, 0, from)] {
                let beside = &mut beside[vertex as usize][side];
                crossed[vertex as usize] |= *beside != NONE;
                *beside = other;
            }
        }
        let moves = |vertex: u32| !crossed[vertex as usize] && !beside[vertex as usize].contains(&NONE);
        let mut around: Vec<[u32; 2]> = (0..)
            .zip(triangles)
            .flat_map(|(triangle, corners)| corners.map(|corner| [corner, triangle]))
            .filter(|&[corner, _]| moves(corner))
            .collect();
        around.sort_unstable();
        let mut border = Border { vertices: Vec::new(), stars: around.iter().map(|&[_, triangle]| triangle).collect() };
        let mut first = 0;
        for star in around.chunk_by(|a, b| a[0] == b[0]) {
            let end = first + star.len();
            let sum: Vector3<f64> =
                border.stars[first..end].iter().map(|&triangle| area(points, triangles[triangle as usize])).sum();
            let number = star[0][0];
            if let Some(normal) = sum.try_normalize(0.0) {
                border.vertices.push(Vertex { number, beside: beside[number as usize], normal, star: [first, end] });
            }
            first = end;
        }
        border
    }
}

impl Vertex {
    /// Where it is to go from where it is.
    fn wanted(&self, surface: &Surface, before: &[Point3<f64>], reach: f64) -> Point3<f64> {
        let at = |number: u32| surface.points[number as usize];
        let (place, [one, other], first) = (at(self.number), self.beside.map(at), before[self.number as usize]);
        let Some(along) = (other - one).try_normalize(0.0) else { return place };
        let to_middle = nalgebra::center(&one, &other) - place;
        let across = to_middle - along * along.dot(&to_middle);
        let way = place + across * SHARE - first;
        let slide = way - self.normal * self.normal.dot(&way);
        first + slide * (reach / slide.norm().max(reach))
    }

    /// Moves it, unless a triangle around it would turn over or get too flat. Whether it did.
    fn move_to(
        &self,
        surface: &mut Surface,
        wanted: Point3<f64>,
        before: &[Point3<f64>],
        border: &Border,
        flat: f64,
    ) -> bool {
        let place = std::mem::replace(&mut surface.points[self.number as usize], wanted);
        let Surface { points, triangles, .. } = &*surface;
        let keeps = |&triangle: &u32| {
            let corners = triangles[triangle as usize];
            let [was, is] = [before, &points[..]].map(|points| area(points, corners));
            let [flat_before, flat_now] = [before, &points[..]].map(|points| altitude(points, corners));
            is.dot(&was) >= TURN * is.norm() * was.norm() && flat_now >= flat.min(flat_before)
        };
        let moves = border.stars[self.star[0]..self.star[1]].iter().all(keeps);
        if !moves {
            surface.points[self.number as usize] = place;
        }
        moves
    }
}

/// The normal of a triangle, as long as twice its area.
fn area(points: &[Point3<f64>], corners: [u32; 3]) -> Vector3<f64> {
    let [a, b, c] = corners.map(|corner| points[corner as usize]);
    (b - a).cross(&(c - a))
}

/// The least altitude of a triangle; 0 for one without size.
fn altitude(points: &[Point3<f64>], corners: [u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| points[corner as usize]);
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    if longest > 0.0 { area(points, corners).norm() / longest } else { 0.0 }
}
