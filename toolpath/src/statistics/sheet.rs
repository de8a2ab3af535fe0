//! The surface as the statistics see it: triangles laid flat one by one, and how each continues in the next.
//!
//! The frame of a triangle has its origin at the tail of the longest edge, `x` along this edge, and the third corner at
//! `y >= 0`. Across an edge a rigid map (with a reflection where the neighbour is turned over) leads from one frame into
//! the next, so a straight line goes on straight. Triangles without area are kept: they hold their neighbours together.

use super::error::StatisticsError;
use nalgebra::{Matrix2, Point3, Vector2, Vector3};

/// A triangle laid flat.
#[derive(Clone, Debug)]
pub(super) struct Flat {
    /// Corners by number.
    pub corners: [u32; 3],
    /// Corners in the frame, in millimetres.
    pub at: [Vector2<f64>; 3],
    /// Origin and axes of the frame in space.
    pub origin: Vector3<f64>,
    pub axes: [Vector3<f64>; 2],
    /// Length of the longest edge, foot and height of the third corner over it.
    pub base: f64,
    pub foot: f64,
    pub height: f64,
}

/// What lies across an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across {
    pub triangle: u32,
    /// The edge there.
    pub edge: u8,
    turn: Matrix2<f64>,
    shift: Vector2<f64>,
}

impl Across {
    /// A point of one frame in the frame across.
    pub(super) fn point(&self, p: Vector2<f64>) -> Vector2<f64> {
        self.turn * p + self.shift
    }

    /// A direction likewise.
    pub(super) fn direction(&self, d: Vector2<f64>) -> Vector2<f64> {
        self.turn * d
    }
}

/// The whole surface.
#[derive(Debug)]
pub(super) struct Sheet {
    pub flats: Vec<Flat>,
    /// Across edge `k`, from corner `k` to the next one, of each triangle; `None` at the boundary.
    pub across: Vec<[Option<Across>; 3]>,
    pub points: Vec<Vector3<f64>>,
    /// Triangles around vertex `v`: `around[first_around[v]..first_around[v + 1]]`.
    around: Vec<u32>,
    first_around: Vec<u32>,
    pub area: f64,
}

/// Coordinates beyond this are refused: their squares, and areas in squares of a step, must stay finite.
const MAX_COORDINATE: f64 = 1e100;

impl Sheet {
    pub(super) fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Sheet, StatisticsError> {
        if triangles.len().max(vertices.len()) > 1 << 29 {
            return Err(StatisticsError::TooLarge { triangles: triangles.len(), vertices: vertices.len() });
        }
        if let Some(vertex) = vertices.iter().position(|p| !p.iter().all(|c| c.abs() <= MAX_COORDINATE)) {
            return Err(StatisticsError::BadVertex { vertex });
        }
        let points: Vec<_> = vertices.iter().map(|p| p.coords).collect();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= points.len()) {
                return Err(StatisticsError::NoSuchVertex { triangle, vertex, vertices: points.len() });
            }
            if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
                return Err(StatisticsError::RepeatedCorner { triangle });
            }
        }
        let flats: Vec<_> = triangles.iter().map(|&corners| flat(&points, corners)).collect();
        let across = neighbours(&flats)?;
        let mut first_around = vec![0u32; points.len() + 1];
        triangles.iter().flatten().for_each(|&v| first_around[v as usize + 1] += 1);
        (0..points.len()).for_each(|v| first_around[v + 1] += first_around[v]);
        let (mut filled, mut around) = (first_around.clone(), vec![0; 3 * triangles.len()]);
        for (triangle, corners) in triangles.iter().enumerate() {
            for &v in corners {
                around[filled[v as usize] as usize] = triangle as u32;
                filled[v as usize] += 1;
            }
        }
        let area = flats.iter().map(|f| f.base * f.height / 2.0).sum();
        let has_area = area > 0.0;
        if !has_area {
            return Err(StatisticsError::NoArea);
        }
        Ok(Sheet { flats, across, points, around, first_around, area })
    }

    /// The triangles at a vertex.
    pub(super) fn around(&self, vertex: u32) -> &[u32] {
        let first = self.first_around[vertex as usize] as usize;
        &self.around[first..self.first_around[vertex as usize + 1] as usize]
    }

    /// A point of a frame in space.
    pub(super) fn lift(&self, triangle: u32, p: Vector2<f64>) -> Vector3<f64> {
        let flat = &self.flats[triangle as usize];
        flat.origin + flat.axes[0] * p.x + flat.axes[1] * p.y
    }

    /// Unit normal of a triangle.
    pub(super) fn normal(&self, triangle: u32) -> Vector3<f64> {
        let [x, y] = self.flats[triangle as usize].axes;
        x.cross(&y)
    }
}

fn flat(points: &[Vector3<f64>], corners: [u32; 3]) -> Flat {
    let p = corners.map(|v| points[v as usize]);
    let lengths = [0, 1, 2].map(|k| (p[(k + 1) % 3] - p[k]).norm());
    let first = (0..3).fold(0, |best, k| if lengths[k] > lengths[best] { k } else { best });
    let base = lengths[first];
    let x = (p[(first + 1) % 3] - p[first]).try_normalize(0.0).unwrap_or_else(Vector3::x);
    let third = p[(first + 2) % 3] - p[first];
    let foot = third.dot(&x);
    let up = third - x * foot;
    // Where the third corner lies on the longest edge any direction across it will do.
    let level = base * MIN_HEIGHT;
    let (y, height) = match up.norm() {
        height if height > level => (up / height, height),
        _ => (any_normal(x), 0.0),
    };
    let mut at = [Vector2::zeros(); 3];
    at[(first + 1) % 3] = Vector2::new(base, 0.0);
    at[(first + 2) % 3] = Vector2::new(foot, height);
    Flat { corners, at, origin: p[first], axes: [x, y], base, foot, height }
}

/// A triangle lower than this share of its longest edge counts as a segment: its plane would be rounding noise.
const MIN_HEIGHT: f64 = 1e-12;

fn any_normal(x: Vector3<f64>) -> Vector3<f64> {
    let other = if x.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    (other - x * x.dot(&other)).normalize()
}

/// Finds what lies across each edge, by sorting edges.
fn neighbours(flats: &[Flat]) -> Result<Vec<[Option<Across>; 3]>, StatisticsError> {
    let mut sides = Vec::with_capacity(3 * flats.len());
    for (t, flat) in flats.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (flat.corners[k], flat.corners[(k + 1) % 3]);
            sides.push((from.min(to), from.max(to), t as u32, k as u8));
        }
    }
    sides.sort_unstable();
    let mut across = vec![[None; 3]; flats.len()];
    for same in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match *same {
            [_] => {}
            [(.., t, k), (.., u, l)] => {
                across[t as usize][k as usize] = Some(join(flats, (t, k), (u, l)));
                across[u as usize][l as usize] = Some(join(flats, (u, l), (t, k)));
            }
            [(from, to, triangle, _), ..] => {
                return Err(StatisticsError::NonManifoldEdge { triangle: triangle as usize, from, to });
            }
            [] => unreachable!("chunks are not empty"),
        }
    }
    Ok(across)
}

/// The map from the frame of one triangle into that of its neighbour.
fn join(flats: &[Flat], (t, k): (u32, u8), (u, l): (u32, u8)) -> Across {
    let (here, there) = (&flats[t as usize], &flats[u as usize]);
    let ends = |flat: &Flat, k: u8| [flat.at[k as usize], flat.at[(k as usize + 1) % 3]];
    let ([a, b], [c, d]) = (ends(here, k), ends(there, l));
    let along = |v: Vector2<f64>| v.try_normalize(0.0).unwrap_or_else(Vector2::x);
    let left = |v: Vector2<f64>| Vector2::new(-v.y, v.x);
    let (e, f) = (along(b - a), along(d - c));
    // Corners run counterclockwise in each frame: outside is to the right of an edge here, inside to its left there.
    let same_way = here.corners[k as usize] == there.corners[l as usize];
    let (image, start) = if same_way { (f, c) } else { (-f, d) };
    let turn = image * e.transpose() - left(f) * left(e).transpose();
    Across { triangle: u, edge: l, turn, shift: start - turn * a }
}
