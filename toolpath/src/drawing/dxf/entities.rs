//! Entities of a DXF file as curves.

use super::error::Fault;
use super::fit;
use super::pair::Record;
use crate::drawing::curve::{Affine, Curve};
use nalgebra::{Matrix2, Point2, Vector2, Vector3};
use std::f64::consts::TAU;

/// What a record draws.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Curves {
        curves: Vec<Curve>,
        closed: bool,
    },
    Insert(Box<Insert>),
    /// Not drawn, and what it is called.
    Skipped(String),
}

/// A block in its places.
#[derive(Clone, Debug)]
pub(super) struct Insert {
    pub name: String,
    pub columns: u64,
    pub rows: u64,
    insertion: Vector2<f64>,
    scale: Vector2<f64>,
    spacing: Vector2<f64>,
    /// Angle, in radians.
    turn: f64,
    plane: Affine,
}

/// Reads a record; `vertices` are those of a POLYLINE.
pub(super) fn shape_of(record: &Record, vertices: &[Record]) -> Result<Shape, Fault> {
    let (curves, closed) = match record.kind.as_str() {
        "LINE" => {
            let from = Point2::new(record.number(10)?, record.number(20)?);
            let to = Point2::new(record.number(11)?, record.number(21)?);
            (vec![Curve::Line { from, to }], false)
        }
        "CIRCLE" => (vec![circle(record, 0.0, TAU)?], false),
        "ARC" => {
            let (from, to) = (record.number(50)?.to_radians(), record.number(51)?.to_radians());
            (vec![circle(record, from, sweep(from, to))?], false)
        }
        "ELLIPSE" => (vec![ellipse(record)?], false),
        "LWPOLYLINE" => light_polyline(record)?,
        "POLYLINE" => match heavy_polyline(record, vertices)? {
            Some(polyline) => polyline,
            None => return Ok(Shape::Skipped("POLYLINE (mesh)".to_owned())),
        },
        "SPLINE" => spline(record)?,
        "INSERT" => return Ok(Shape::Insert(Box::new(insert(record)?))),
        other => return Ok(Shape::Skipped(other.to_owned())),
    };
    let point = |curve: &Curve| matches!(curve, Curve::Line { from, to } if from == to);
    if curves.iter().all(point) {
        return Err(Fault::new("it has no length"));
    }
    Ok(Shape::Curves { curves, closed })
}

fn circle(record: &Record, from: f64, sweep: f64) -> Result<Curve, Fault> {
    let centre = Point2::new(record.number(10)?, record.number(20)?);
    Ok(Curve::circle(centre, positive(record, 40, "radius")?, from, sweep).mapped(&extrusion(record)?))
}

fn ellipse(record: &Record) -> Result<Curve, Fault> {
    let centre = Point2::new(record.number(10)?, record.number(20)?);
    let major = Vector3::new(record.number(11)?, record.number(21)?, record.number_or(31, 0.0)?);
    if major.norm() <= 0.0 {
        return Err(Fault::new("its major axis has the length 0"));
    }
    let minor = normal(record)?.cross(&major) * positive(record, 40, "ratio of axes")?;
    let (from, to) = (record.number_or(41, 0.0)?, record.number_or(42, TAU)?);
    Ok(Curve::Arc { centre, u: major.xy(), v: minor.xy(), from, sweep: sweep(from, to) })
}

/// Curves, and whether they are closed.
type Polyline = (Vec<Curve>, bool);

fn light_polyline(record: &Record) -> Result<Polyline, Fault> {
    let mut corners: Vec<(Point2<f64>, f64)> = Vec::new();
    for pair in &record.pairs {
        match (pair.code, corners.last_mut()) {
            (10, _) => corners.push((Point2::new(pair.number()?, 0.0), 0.0)),
            (20, Some((corner, _))) => corner.y = pair.number()?,
            (42, Some((_, bulge))) => *bulge = pair.number()?,
            _ => {}
        }
    }
    polyline(record, &corners, record.whole_or(70, 0)? & 1 == 1)
}

/// `None` for a mesh.
fn heavy_polyline(record: &Record, vertices: &[Record]) -> Result<Option<Polyline>, Fault> {
    let flags = record.whole_or(70, 0)?;
    if flags & (16 | 64) != 0 {
        return Ok(None);
    }
    let mut corners = Vec::new();
    for vertex in vertices {
        // Control points of a curve that is there as vertices, too.
        if vertex.whole_or(70, 0)? & 16 == 0 {
            corners.push((Point2::new(vertex.number(10)?, vertex.number(20)?), vertex.number_or(42, 0.0)?));
        }
    }
    polyline(record, &corners, flags & 1 == 1).map(Some)
}

/// By control points, or by the points that it passes through if the file has no others.
fn spline(record: &Record) -> Result<Polyline, Fault> {
    let points = points_of(record, 10, 20)?;
    let closed = record.whole_or(70, 0)? & 1 == 1;
    if points.is_empty() && record.find(11).is_some() {
        return fitted(record, closed);
    }
    let degree = usize::try_from(record.whole_or(71, 3)?).unwrap_or(0);
    let (knots, weights) = (record.numbers(40)?, record.numbers(41)?);
    let spline = Curve::Spline { degree, knots, points, weights };
    spline.check().map_err(|fault| Fault::new(fault.to_string()))?;
    Ok((vec![spline], closed))
}

fn fitted(record: &Record, closed: bool) -> Result<Polyline, Fault> {
    let mut points = points_of(record, 11, 21)?;
    points.dedup();
    let tangent = |x: i32, y: i32| -> Result<Option<Vector2<f64>>, Fault> {
        match record.find(x) {
            Some(x) => Ok(Some(Vector2::new(x.number()?, record.number(y)?))),
            None => Ok(None),
        }
    };
    let tangents = [tangent(12, 22)?, tangent(13, 23)?];
    let returns = points.len() > 2 && points.first() == points.last();
    // With tangents a spline that returns may have a corner there.
    let smooth = closed || (returns && tangents == [None, None]);
    if returns && smooth {
        points.pop();
    }
    if points.len() < 2 {
        return Err(Fault::new("it has fewer than two fit points"));
    }
    Ok((fit::through(&points, tangents, smooth), closed || returns))
}

fn points_of(record: &Record, x: i32, y: i32) -> Result<Vec<Point2<f64>>, Fault> {
    Ok(record.numbers(x)?.into_iter().zip(record.numbers(y)?).map(|(x, y)| Point2::new(x, y)).collect())
}

fn insert(record: &Record) -> Result<Insert, Fault> {
    let count = |code| -> Result<u64, Fault> {
        // Files have 0 where there is no array.
        Ok(record.whole_or(code, 1)?.max(1).unsigned_abs())
    };
    Ok(Insert {
        name: record.text(2).to_owned(),
        columns: count(70)?,
        rows: count(71)?,
        insertion: Vector2::new(record.number(10)?, record.number(20)?),
        scale: Vector2::new(record.number_or(41, 1.0)?, record.number_or(42, 1.0)?),
        spacing: Vector2::new(record.number_or(44, 0.0)?, record.number_or(45, 0.0)?),
        turn: record.number_or(50, 0.0)?.to_radians(),
        plane: extrusion(record)?,
    })
}

impl Insert {
    /// How often the block is inserted.
    pub fn count(&self) -> u64 {
        self.columns.saturating_mul(self.rows)
    }

    /// Where it puts a block with this base point, at one place of its array.
    pub fn placement(&self, base: [f64; 2], at: [f64; 2]) -> Affine {
        let (sin, cos) = self.turn.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let matrix = turn * Matrix2::from_diagonal(&self.scale);
        let shift =
            self.insertion + turn * self.spacing.component_mul(&Vector2::from(at)) - matrix * Vector2::from(base);
        self.plane.after(&Affine { matrix, shift })
    }
}

/// Segments and arcs between corners.
fn polyline(record: &Record, corners: &[(Point2<f64>, f64)], closed: bool) -> Result<Polyline, Fault> {
    if corners.len() < 2 {
        return Err(Fault::new("it has fewer than two vertices"));
    }
    let map = extrusion(record)?;
    let back = closed.then_some([corners[corners.len() - 1], corners[0]]);
    let pairs = corners.windows(2).map(|pair| [pair[0], pair[1]]).chain(back);
    // Equal neighbours draw nothing.
    let curves = pairs.filter(|[(from, _), (to, _)]| from != to);
    Ok((curves.map(|[(from, bulge), (to, _)]| Curve::bulge(from, to, bulge).mapped(&map)).collect(), closed))
}

/// How far an arc goes, counter-clockwise: a whole turn where it would be none.
fn sweep(from: f64, to: f64) -> f64 {
    let sweep = (to - from).rem_euclid(TAU);
    if sweep > 0.0 { sweep } else { TAU }
}

fn positive(record: &Record, code: i32, name: &str) -> Result<f64, Fault> {
    let value = record.number(code)?;
    if value > 0.0 { Ok(value) } else { Err(Fault::new(format!("its {name} is {value}"))) }
}

/// The direction of extrusion, of length 1.
fn normal(record: &Record) -> Result<Vector3<f64>, Fault> {
    let normal = Vector3::new(record.number_or(210, 0.0)?, record.number_or(220, 0.0)?, record.number_or(230, 1.0)?);
    normal.try_normalize(1e-9).ok_or_else(|| Fault::new("its extrusion has the length 0"))
}

/// From the entity's own plane to the drawing, seen from above: the arbitrary axis algorithm of the DXF reference.
fn extrusion(record: &Record) -> Result<Affine, Fault> {
    let normal = normal(record)?;
    let near_z = normal.x.abs() < 1.0 / 64.0 && normal.y.abs() < 1.0 / 64.0;
    let across = if near_z { Vector3::y() } else { Vector3::z() };
    // Never zero: the normal is not near this axis.
    let x = across.cross(&normal).normalize();
    let y = normal.cross(&x);
    let code = if record.kind == "LWPOLYLINE" { 38 } else { 30 };
    let shift = normal.xy() * record.number_or(code, 0.0)?;
    Ok(Affine { matrix: Matrix2::from_columns(&[x.xy(), y.xy()]), shift })
}
