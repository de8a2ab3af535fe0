//! Entities of a DXF file as curves.

use super::DxfError;
use super::pairs::Record;
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
    Insert {
        name: String,
        columns: u64,
        rows: u64,
    },
    /// Not drawn, and what it is called.
    Skipped(String),
}

/// Reads a record; `vertices` are those of a POLYLINE.
pub(super) fn shape_of(record: &Record, vertices: &[Record]) -> Result<Shape, DxfError> {
    let (curves, closed) = match record.kind.as_str() {
        "LINE" => {
            let from = Point2::new(record.number(10)?, record.number(20)?);
            let to = Point2::new(record.number(11)?, record.number(21)?);
            (vec![Curve::Line { from, to }], false)
        }
        "CIRCLE" | "ARC" => {
            let centre = Point2::new(record.number(10)?, record.number(20)?);
            let radius = positive(record, 40, "radius")?;
            let (from, sweep) = if record.kind == "CIRCLE" {
                (0.0, TAU)
            } else {
                let (from, to) = (record.number(50)?, record.number(51)?);
                (from.to_radians(), sweep(from.to_radians(), to.to_radians()))
            };
            (vec![Curve::circle(centre, radius, from, sweep).mapped(&extrusion(record)?)], false)
        }
        "ELLIPSE" => {
            let centre = Point2::new(record.number(10)?, record.number(20)?);
            let major = Vector3::new(record.number(11)?, record.number(21)?, record.number_or(31, 0.0)?);
            if major.norm() <= 0.0 {
                return Err(wrong(record, "has a major axis of length 0"));
            }
            let minor = normal(record)?.cross(&major) * positive(record, 40, "ratio of axes")?;
            let (from, to) = (record.number_or(41, 0.0)?, record.number_or(42, TAU)?);
            (vec![Curve::Arc { centre, u: major.xy(), v: minor.xy(), from, sweep: sweep(from, to) }], false)
        }
        "LWPOLYLINE" => {
            let mut corners: Vec<(Point2<f64>, f64)> = Vec::new();
            for pair in &record.pairs {
                match (pair.code, corners.last_mut()) {
                    (10, _) => corners.push((Point2::new(pair.number()?, 0.0), 0.0)),
                    (20, Some((corner, _))) => corner.y = pair.number()?,
                    (42, Some((_, bulge))) => *bulge = pair.number()?,
                    _ => {}
                }
            }
            polyline(record, &corners, record.whole_or(70, 0)? & 1 == 1)?
        }
        "POLYLINE" => {
            let flags = record.whole_or(70, 0)?;
            if flags & (16 | 64) != 0 {
                return Ok(Shape::Skipped("POLYLINE (mesh)".to_owned()));
            }
            let mut corners = Vec::new();
            for vertex in vertices {
                // Control points of a curve that is there as vertices, too.
                if vertex.whole_or(70, 0)? & 16 == 0 {
                    corners.push((Point2::new(vertex.number(10)?, vertex.number(20)?), vertex.number_or(42, 0.0)?));
                }
            }
            polyline(record, &corners, flags & 1 == 1)?
        }
        "SPLINE" => {
            let points: Vec<Point2<f64>> =
                record.numbers(10)?.into_iter().zip(record.numbers(20)?).map(|(x, y)| Point2::new(x, y)).collect();
            if points.is_empty() && record.find(11).is_some() {
                return Ok(Shape::Skipped("SPLINE (fit points only)".to_owned()));
            }
            let degree = usize::try_from(record.whole_or(71, 3)?).unwrap_or(0);
            let (knots, weights) = (record.numbers(40)?, record.numbers(41)?);
            let spline = Curve::Spline { degree, knots, points, weights };
            spline.check().map_err(|fault| wrong(record, &format!("is invalid: {fault}")))?;
            (vec![spline], record.whole_or(70, 0)? & 1 == 1)
        }
        "INSERT" => {
            let count = |code| -> Result<u64, DxfError> {
                let count = record.whole_or(code, 1)?;
                // Files have 0 where there is no array.
                u64::try_from(count.max(1)).map_err(|_| wrong(record, "has an array that cannot be"))
            };
            return Ok(Shape::Insert { name: record.text(2).to_owned(), columns: count(70)?, rows: count(71)? });
        }
        other => return Ok(Shape::Skipped(other.to_owned())),
    };
    Ok(Shape::Curves { curves, closed })
}

/// Where an INSERT puts the block, at one place of its array.
pub(super) fn placement(record: &Record, base: [f64; 2], at: [f64; 2]) -> Result<Affine, DxfError> {
    let insertion = Vector2::new(record.number(10)?, record.number(20)?);
    let scale = Vector2::new(record.number_or(41, 1.0)?, record.number_or(42, 1.0)?);
    let spacing = Vector2::new(record.number_or(44, 0.0)?, record.number_or(45, 0.0)?);
    let (sin, cos) = record.number_or(50, 0.0)?.to_radians().sin_cos();
    let turn = Matrix2::new(cos, -sin, sin, cos);
    let matrix = turn * Matrix2::from_diagonal(&scale);
    let shift = insertion + turn * spacing.component_mul(&Vector2::from(at)) - matrix * Vector2::from(base);
    Ok(extrusion(record)?.after(&Affine { matrix, shift }))
}

/// Segments and arcs between corners.
fn polyline(record: &Record, corners: &[(Point2<f64>, f64)], closed: bool) -> Result<(Vec<Curve>, bool), DxfError> {
    if corners.len() < 2 {
        return Err(wrong(record, "has fewer than two vertices"));
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

fn positive(record: &Record, code: i32, name: &str) -> Result<f64, DxfError> {
    let value = record.number(code)?;
    if value > 0.0 { Ok(value) } else { Err(wrong(record, &format!("has a {name} of {value}; it must be above 0"))) }
}

fn wrong(record: &Record, what: &str) -> DxfError {
    DxfError::Entity { line: record.line, kind: record.kind.clone(), what: what.to_owned() }
}

/// The direction of extrusion, of length 1.
fn normal(record: &Record) -> Result<Vector3<f64>, DxfError> {
    let normal = Vector3::new(record.number_or(210, 0.0)?, record.number_or(220, 0.0)?, record.number_or(230, 1.0)?);
    normal.try_normalize(1e-9).ok_or_else(|| wrong(record, "has an extrusion of length 0"))
}

/// From the entity's own plane to the drawing, seen from above: the arbitrary axis algorithm of the DXF reference.
fn extrusion(record: &Record) -> Result<Affine, DxfError> {
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
