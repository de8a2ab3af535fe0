//! What stands in a scene: shapes, what they are mounted on, and the checks at the door.

use super::cells::CellTree;
use super::mesh::MeshTree;
use super::piece::{Form, Piece};
use crate::pose::MAX_COORDINATE;
use crate::pose::parts;
use nalgebra::{Isometry3, Point3};
use std::f64::consts::{PI, TAU};

/// More cells than this along an axis are a mistake.
const MAX_CELLS: u32 = 1 << 24;

/// What a body is fixed to; its coordinates are those of that frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mount {
    /// The base of the arm, which is the world.
    Base,
    /// The frame behind joint 1 to 6 of the arm, as in [`Arm::frames`](crate::Arm::frames); 6 is the flange.
    Link(usize),
    /// What the tilt axis of the positioner moves and the turn axis does not: the table frame as it is at turn 0.
    Tilt,
    /// The table of the positioner.
    Table,
    /// What stands still while a track carries the base of the arm along: seen from the base it goes the other way.
    Ground,
    /// The same for what the carriage of the track runs on or next to: it is not compared with bodies on the base that are no links.
    Rail,
}

impl Mount {
    /// Whether joint `k` of the arm, or axis `k` of the positioner or the track, moves what is mounted here; counted from 0.
    pub(super) fn is_moved_by(self, on_table: bool, k: usize) -> bool {
        match self {
            Mount::Base => false,
            Mount::Link(link) => !on_table && k < link,
            Mount::Tilt => on_table && k == 0,
            Mount::Table => on_table,
            Mount::Ground | Mount::Rail => on_table && k == 0,
        }
    }
}

/// The shape of a body, in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points within `radius` of a line from `from` to `to`; a ball when these are the same.
    Capsule {
        /// One end.
        from: Point3<f64>,
        /// The other.
        to: Point3<f64>,
        /// The radius; 0 leaves the line.
        radius: f64,
    },
    /// The convex hull of points, grown by `radius`. Points within it do no harm but cost time.
    Hull {
        /// One or more.
        points: Vec<Point3<f64>>,
        /// The radius, 0 or more.
        radius: f64,
    },
    /// The surface of triangles. What lies wholly within a closed one does not touch it.
    Mesh {
        /// The points.
        points: Vec<Point3<f64>>,
        /// Corners of the triangles.
        triangles: Vec<[u32; 3]>,
    },
    /// Solid cells: cubes on a grid with a corner at the origin of the body.
    Cells {
        /// Cells along x, y and z.
        dims: [u32; 3],
        /// Bit `x % 64` of word `x / 64` of row `y + ny z`, each row in whole words.
        rows: Vec<u64>,
        /// The edge of a cell.
        cell: f64,
    },
    /// All points of several shapes.
    Union(Vec<Shape>),
}

/// Sides of the prism that stands for a cylinder: it is at most 3.6 % wider.
const SIDES: usize = 12;

impl Shape {
    /// A cylinder about z from `low` to `high`, as the hull of a twelve-sided prism that contains it.
    pub fn cylinder(radius: f64, low: f64, high: f64) -> Self {
        let out = radius / (PI / SIDES as f64).cos();
        let corner = |k: usize| {
            let (sin, cos) = (TAU * (k / 2) as f64 / SIDES as f64).sin_cos();
            Point3::new(out * cos, out * sin, if k.is_multiple_of(2) { low } else { high })
        };
        Shape::Hull { points: (0..2 * SIDES).map(corner).collect(), radius: 0.0 }
    }

    /// A box along the axes from one corner to the opposite one.
    pub fn block(low: Point3<f64>, high: Point3<f64>) -> Self {
        let corner = |k: usize| {
            let pick = |axis: usize| if k >> axis & 1 == 1 { high[axis] } else { low[axis] };
            Point3::new(pick(0), pick(1), pick(2))
        };
        Shape::Hull { points: (0..8).map(corner).collect(), radius: 0.0 }
    }
}

/// A body that is fixed to something.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name, by which answers call it.
    pub name: String,
    /// What it is fixed to.
    pub mount: Mount,
    /// Where its frame is in that of the mount.
    pub mount_body: Isometry3<f64>,
    /// What it is.
    pub shape: Shape,
}

/// Why a scene is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Two bodies have the same name.
    #[error("two bodies are called `{name}`")]
    SameName {
        /// The name.
        name: String,
    },
    /// No body has this name.
    #[error("no body is called `{name}`")]
    NoBody {
        /// The name.
        name: String,
    },
    /// A link that no arm has.
    #[error("body `{body}` is on link {link}: links are 1 to 6, 6 being the flange")]
    Link {
        /// The body.
        body: String,
        /// What was asked for.
        link: usize,
    },
    /// A body is on a table, but the scene has no table.
    #[error("body `{body}` is on the positioner, but the scene has none")]
    NoPositioner {
        /// The body.
        body: String,
    },
    /// A body stands beside a track, but the scene has no track.
    #[error("body `{body}` stands on the ground of a track, but the scene has none")]
    NoTrack {
        /// The body.
        body: String,
    },
    /// Table and track: only one of the two can be there.
    #[error("the scene has a positioner and a track: only one of the two can be there")]
    TableAndTrack,
    /// The pose of a body on its mount is invalid.
    #[error(
        "the pose of body `{body}` is invalid: its entries must be finite and at most 1e6 mm, its quaternion of length 1"
    )]
    Pose {
        /// The body.
        body: String,
    },
    /// A coordinate is not a number, or too far out.
    #[error("point {point} of body `{body}` is {value:?}: coordinates must be numbers up to 1e6 mm")]
    Point {
        /// The body.
        body: String,
        /// Which point; of a capsule 0 and 1.
        point: usize,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// A radius or the edge of a cell is no length.
    #[error("the {what} of body `{body}` is {value}: it must be a length up to 1e6 mm")]
    Length {
        /// The body.
        body: String,
        /// `radius` or `cell`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// There are no points, no triangles, no cells or no shapes.
    #[error("body `{body}` has no {what}")]
    Empty {
        /// The body.
        body: String,
        /// `points`, `triangles`, `cells` or `shapes`.
        what: &'static str,
    },
    /// A corner of a triangle is no point.
    #[error("triangle {triangle} of body `{body}` has corner {corner}, and there are {points} points")]
    Corner {
        /// The body.
        body: String,
        /// Which triangle.
        triangle: usize,
        /// Its corner.
        corner: u32,
        /// How many points there are.
        points: usize,
    },
    /// The words do not fit the grid.
    #[error("body `{body}` has {found} words of cells; a grid of {dims:?} has {expected}")]
    Words {
        /// The body.
        body: String,
        /// The grid.
        dims: [u32; 3],
        /// Words it needs.
        expected: u128,
        /// Words there are.
        found: usize,
    },
    /// A cell lies beyond the end of its row.
    #[error("row {row} of body `{body}` has a cell beyond its {nx} cells")]
    BeyondRow {
        /// The body.
        body: String,
        /// `y + ny z`.
        row: usize,
        /// Cells of a row.
        nx: u32,
    },
    /// Triangles were to be added to what is no mesh, or cells to what has none.
    #[error("body `{body}` is not made of {what}, so none can be added")]
    OtherShape {
        /// The body.
        body: String,
        /// `triangles` or `cells`.
        what: &'static str,
    },
    /// The allowance of the links is no length.
    #[error("the allowance of the links is {value}: it must be a length from 0 to 1e6 mm")]
    Allowance {
        /// Its value.
        value: f64,
    },
    /// The clearance is no length.
    #[error("the clearance is {value}: it must be a length from 0 to 1e6 mm")]
    Clearance {
        /// Its value.
        value: f64,
    },
    /// The margin is no length.
    #[error("the margin is {value}: it must be a length from 0 to 1e6 mm")]
    Margin {
        /// Its value.
        value: f64,
    },
}

/// The pieces of a body.
pub(super) fn pieces(body: &Body) -> Result<Vec<Piece>, SceneError> {
    let name = || body.name.clone();
    let sound = parts(&body.mount_body).is_ok() && body.mount_body.translation.vector.amax() <= MAX_COORDINATE;
    if !sound {
        return Err(SceneError::Pose { body: name() });
    }
    shape_pieces(body, &body.shape)
}

/// The pieces of a shape of a body whose pose is sound.
fn shape_pieces(body: &Body, shape: &Shape) -> Result<Vec<Piece>, SceneError> {
    let name = || body.name.clone();
    let length = |what, value: f64, least: f64| {
        let fine = value >= least && value <= MAX_COORDINATE;
        if fine { Ok(()) } else { Err(SceneError::Length { body: name(), what, value }) }
    };
    let piece = match shape {
        Shape::Union(shapes) => {
            if shapes.is_empty() {
                return Err(SceneError::Empty { body: name(), what: "shapes" });
            }
            let all: Result<Vec<Vec<Piece>>, SceneError> =
                shapes.iter().map(|shape| shape_pieces(body, shape)).collect();
            return Ok(all?.into_iter().flatten().collect());
        }
        Shape::Capsule { from, to, radius } => {
            check_points(&body.name, &[*from, *to])?;
            length("radius", *radius, 0.0)?;
            Piece::capsule(from, to, *radius, &body.mount_body)
        }
        Shape::Hull { points, radius } => {
            if points.is_empty() {
                return Err(SceneError::Empty { body: name(), what: "points" });
            }
            check_points(&body.name, points)?;
            length("radius", *radius, 0.0)?;
            Piece::hull(points.clone(), *radius, body.mount_body)
        }
        Shape::Mesh { points, triangles } => mesh(body, points, triangles)?,
        Shape::Cells { dims, rows, cell } => {
            length("cell", *cell, f64::MIN_POSITIVE)?;
            if dims.contains(&0) {
                return Err(SceneError::Empty { body: name(), what: "cells" });
            }
            let longest = dims.iter().fold(0, |a, &b| a.max(b));
            length("cell", *cell * f64::from(longest), f64::MIN_POSITIVE)?;
            check_rows(&body.name, *dims, rows)?;
            let mut cells = CellTree::new(*dims, *cell);
            cells.add(rows);
            Piece::new(Form::Cells(cells), 0.0, body.mount_body)
        }
    };
    Ok(vec![piece])
}

/// A piece of triangles.
pub(super) fn mesh(body: &Body, points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Piece, SceneError> {
    if triangles.is_empty() {
        return Err(SceneError::Empty { body: body.name.clone(), what: "triangles" });
    }
    check_points(&body.name, points)?;
    let corner = |(triangle, corner): (usize, u32)| {
        points.get(corner as usize).copied().ok_or_else(|| SceneError::Corner {
            body: body.name.clone(),
            triangle,
            corner,
            points: points.len(),
        })
    };
    let corners =
        triangles.iter().enumerate().map(|(k, t)| Ok([corner((k, t[0]))?, corner((k, t[1]))?, corner((k, t[2]))?]));
    let corners: Result<Vec<_>, SceneError> = corners.collect();
    Ok(Piece::new(Form::Mesh(MeshTree::new(corners?)), 0.0, body.mount_body))
}

fn check_points(body: &str, points: &[Point3<f64>]) -> Result<(), SceneError> {
    // NaN fails the comparison.
    let fits = |point: &Point3<f64>| point.iter().all(|x| x.abs() <= MAX_COORDINATE);
    match points.iter().position(|point| !fits(point)) {
        Some(point) => Err(SceneError::Point { body: body.into(), point, value: points[point].coords.into() }),
        None => Ok(()),
    }
}

/// Whether rows of cells fit their grid.
pub(super) fn check_rows(body: &str, dims: [u32; 3], rows: &[u64]) -> Result<(), SceneError> {
    let words = dims[0].div_ceil(64);
    let expected = u128::from(words) * u128::from(dims[1]) * u128::from(dims[2]);
    if expected != rows.len() as u128 || dims.iter().any(|&n| n > MAX_CELLS) {
        return Err(SceneError::Words { body: body.into(), dims, expected, found: rows.len() });
    }
    let beyond = if dims[0].is_multiple_of(64) { 0 } else { u64::MAX << (dims[0] % 64) };
    match rows.chunks_exact(words as usize).position(|row| row[row.len() - 1] & beyond != 0) {
        Some(row) => Err(SceneError::BeyondRow { body: body.into(), row, nx: dims[0] }),
        None => Ok(()),
    }
}
