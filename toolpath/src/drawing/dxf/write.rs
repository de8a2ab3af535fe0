//! Drawings as ASCII DXF files: Brooks, code snippet 4-1, where a design of points is saved.
//!
//! Written are LINE, CIRCLE, ARC, ELLIPSE, SPLINE, and LWPOLYLINE where an entity has several lines and arcs; exact, but for the rounding
//! of angles. AutoCAD 2000 (AC1015), model space, millimetres. Clockwise arcs of circles and ellipses are written the other way round,
//! since the format has no others.

use crate::drawing::curve::Curve;
use crate::drawing::drawing::{Drawing, Entity};
use nalgebra::{Matrix2, Point2, Point3, Vector2};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::io::{self, Write};

/// Writes a drawing. Entities that no one DXF entity can say become several, which meet at their ends; what the drawing skipped is not
/// there, and names of layers lose characters that the format does not take.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] for an entity with a curve that cannot be evaluated, before anything is written; and what the
/// writer reports.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{Curve, Drawing, read_dxf, write_dxf};
/// use curvlay_toolpath::nalgebra::Point2;
/// let mut drawing = Drawing::default();
/// drawing.add("RIM", [Curve::circle(Point2::new(1.0, 2.0), 10.0, 0.0, std::f64::consts::TAU)]);
/// let mut file = Vec::new();
/// write_dxf(&mut file, &drawing)?;
/// let read = read_dxf(file.as_slice()).map_err(std::io::Error::other)?;
/// assert_eq!((read.entities[0].kind.as_str(), &read.entities[0].curves), ("CIRCLE", &drawing.entities[0].curves));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_dxf(out: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    for (number, entity) in drawing.entities.iter().enumerate() {
        if let Some(fault) = entity.curves.iter().find_map(|curve| curve.check().err()) {
            let what = format!("entity {} ({}) cannot be written: {fault}", number + 1, entity.kind);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
    }
    let mut file = Pairs { out, handle: FIRST_HANDLE };
    file.begin(drawing.entities.iter().map(|entity| entity.layer.as_str()))?;
    for entity in &drawing.entities {
        file.entity(entity)?;
    }
    file.end()
}

/// A path in space, as beads lie on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SpacePath {
    /// Its layer.
    pub layer: String,
    /// Its points, in millimetres.
    pub points: Vec<Point3<f64>>,
    /// Whether a segment leads from the last point to the first.
    pub closed: bool,
}

/// Writes paths in space, each as a POLYLINE in three dimensions: Brooks, section 4.12, where the points on the dome are saved.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] for a path with fewer than two points or a coordinate that is not finite, before anything is written; and what
/// the writer reports.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{SpacePath, read_dxf, write_paths_dxf};
/// use curvlay_toolpath::nalgebra::Point3;
/// let points = vec![Point3::new(0.0, 0.0, 150.0), Point3::new(30.0, 0.0, 147.0), Point3::new(30.0, 40.0, 143.5)];
/// let mut file = Vec::new();
/// write_paths_dxf(&mut file, &[SpacePath { layer: "fill".to_owned(), points, closed: true }])?;
/// assert!(String::from_utf8_lossy(&file).contains("\n30\n143.5\n"));
/// // As a drawing it is seen from above.
/// let drawing = read_dxf(file.as_slice()).map_err(std::io::Error::other)?;
/// assert_eq!((drawing.entities[0].kind.as_str(), drawing.entities[0].curves.len()), ("POLYLINE", 3));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_paths_dxf(out: &mut impl Write, paths: &[SpacePath]) -> io::Result<()> {
    let fits =
        |path: &SpacePath| path.points.len() >= 2 && path.points.iter().flat_map(Point3::iter).all(|x| x.is_finite());
    if let Some(number) = paths.iter().position(|path| !fits(path)) {
        let what = format!("path {number} cannot be written: it needs two points or more, with finite coordinates");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    let mut file = Pairs { out, handle: FIRST_HANDLE };
    file.begin(paths.iter().map(|path| path.layer.as_str()))?;
    for path in paths {
        file.in_space(path)?;
    }
    file.end()
}

/// Handles below are those of the tables.
const FIRST_HANDLE: u64 = 0x100;

/// A name of a layer without what the format does not take, and not empty.
fn name(layer: &str) -> String {
    let name: String =
        layer.chars().map(|c| if c.is_control() || "<>/\\\":;?*|=`".contains(c) { '_' } else { c }).collect();
    let name = name.trim();
    if name.is_empty() { "0".to_owned() } else { name.to_owned() }
}

struct Pairs<'a, W> {
    out: &'a mut W,
    handle: u64,
}

impl<W: Write> Pairs<'_, W> {
    /// Header and tables, up to the entities.
    fn begin<'a>(&mut self, layers: impl Iterator<Item = &'a str>) -> io::Result<()> {
        self.texts(&[(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS"), (70, "4")])?;
        self.texts(&[(9, "$HANDSEED"), (5, "FFFFFF"), (0, "ENDSEC"), (0, "SECTION"), (2, "TABLES")])?;
        self.texts(&[(0, "TABLE"), (2, "LTYPE"), (5, "5"), (100, "AcDbSymbolTable"), (70, "1")])?;
        self.texts(&[(0, "LTYPE"), (5, "14"), (100, "AcDbSymbolTableRecord"), (100, "AcDbLinetypeTableRecord")])?;
        self.texts(&[(2, "CONTINUOUS"), (70, "0"), (3, ""), (72, "65"), (73, "0"), (40, "0.0"), (0, "ENDTAB")])?;
        let layers: BTreeSet<String> = std::iter::once("0".to_owned()).chain(layers.map(name)).collect();
        let count = layers.len().to_string();
        self.texts(&[(0, "TABLE"), (2, "LAYER"), (5, "2"), (100, "AcDbSymbolTable"), (70, &count)])?;
        for layer in &layers {
            let handle = self.next_handle();
            self.texts(&[(0, "LAYER"), (5, &handle), (100, "AcDbSymbolTableRecord"), (100, "AcDbLayerTableRecord")])?;
            self.texts(&[(2, layer), (70, "0"), (62, "7"), (6, "CONTINUOUS")])?;
        }
        self.texts(&[(0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")])
    }

    fn end(&mut self) -> io::Result<()> {
        self.texts(&[(0, "ENDSEC"), (0, "EOF")])?;
        self.out.flush()
    }

    fn in_space(&mut self, path: &SpacePath) -> io::Result<()> {
        self.head("POLYLINE", &path.layer, "AcDb3dPolyline")?;
        // Vertices follow; in three dimensions, and closed or not.
        self.texts(&[(66, "1"), (10, "0.0"), (20, "0.0"), (30, "0.0"), (70, if path.closed { "9" } else { "8" })])?;
        for at in &path.points {
            self.head("VERTEX", &path.layer, "AcDbVertex")?;
            self.texts(&[(100, "AcDb3dPolylineVertex")])?;
            self.numbers(&[(10, at.x), (20, at.y), (30, at.z)])?;
            self.texts(&[(70, "32")])?;
        }
        let handle = self.next_handle();
        self.texts(&[(0, "SEQEND"), (5, &handle), (100, "AcDbEntity"), (8, &name(&path.layer))])
    }

    fn texts(&mut self, pairs: &[(i32, &str)]) -> io::Result<()> {
        pairs.iter().try_for_each(|(code, text)| write!(self.out, "{code}\n{text}\n"))
    }

    fn numbers(&mut self, pairs: &[(i32, f64)]) -> io::Result<()> {
        // The shortest digits that are read as the same number.
        pairs.iter().try_for_each(|(code, value)| write!(self.out, "{code}\n{value:?}\n"))
    }

    fn next_handle(&mut self) -> String {
        self.handle += 1;
        format!("{:X}", self.handle)
    }

    fn head(&mut self, kind: &str, layer: &str, class: &str) -> io::Result<()> {
        let handle = self.next_handle();
        self.texts(&[(0, kind), (5, &handle), (100, "AcDbEntity"), (8, &name(layer)), (100, class)])
    }

    fn entity(&mut self, entity: &Entity) -> io::Result<()> {
        let layer = &entity.layer;
        let corners = corners(&entity.curves);
        match (entity.curves.as_slice(), corners) {
            ([one], _) if !entity.closed => self.curve(layer, one),
            (_, Some((corners, end))) => {
                let returns = corners.first().is_some_and(|(first, _)| *first == end);
                let closed = entity.closed || returns;
                self.polyline(layer, &corners, (!returns).then_some(end), closed)
            }
            (curves, None) => {
                curves.iter().try_for_each(|curve| self.curve(layer, curve))?;
                let ends = entity
                    .curves
                    .last()
                    .map(|curve| curve.ends()[1])
                    .zip(entity.curves.first().map(|curve| curve.ends()[0]));
                match ends {
                    Some((from, to)) if entity.closed && from != to => self.curve(layer, &Curve::Line { from, to }),
                    _ => Ok(()),
                }
            }
        }
    }

    fn polyline(&mut self, layer: &str, corners: &[Corner], end: Option<Point2<f64>>, closed: bool) -> io::Result<()> {
        if corners.is_empty() {
            return Ok(());
        }
        let all = || corners.iter().copied().chain(end.map(|end| (end, 0.0)));
        let (count, flag) = (all().count().to_string(), if closed { "1" } else { "0" });
        self.head("LWPOLYLINE", layer, "AcDbPolyline")?;
        self.texts(&[(90, &count), (70, flag)])?;
        for (corner, bulge) in all() {
            self.numbers(&[(10, corner.x), (20, corner.y)])?;
            if bulge.abs() > 0.0 {
                self.numbers(&[(42, bulge)])?;
            }
        }
        Ok(())
    }

    fn curve(&mut self, layer: &str, curve: &Curve) -> io::Result<()> {
        match curve {
            Curve::Line { from, to } => {
                self.head("LINE", layer, "AcDbLine")?;
                self.numbers(&[(10, from.x), (20, from.y), (30, 0.0), (11, to.x), (21, to.y), (31, 0.0)])
            }
            Curve::Arc { centre, u, v, from, sweep } => self.arc(layer, centre, u, v, [*from, *sweep]),
            Curve::Spline { degree, knots, points, weights } => {
                let rational = !weights.is_empty();
                self.head("SPLINE", layer, "AcDbSpline")?;
                let flags = if rational { "12" } else { "8" };
                let [degree, knot_count, point_count] = [*degree, knots.len(), points.len()].map(|n| n.to_string());
                self.texts(&[(70, flags), (71, &degree), (72, &knot_count), (73, &point_count), (74, "0")])?;
                knots.iter().try_for_each(|knot| self.numbers(&[(40, *knot)]))?;
                weights.iter().try_for_each(|weight| self.numbers(&[(41, *weight)]))?;
                points.iter().try_for_each(|point| self.numbers(&[(10, point.x), (20, point.y), (30, 0.0)]))
            }
        }
    }

    fn arc(
        &mut self,
        layer: &str,
        centre: &Point2<f64>,
        u: &Vector2<f64>,
        v: &Vector2<f64>,
        [from, sweep]: [f64; 2],
    ) -> io::Result<()> {
        let whole = sweep.abs() >= TAU;
        if let Some(radius) = circle_radius(u, v) {
            if whole {
                self.head("CIRCLE", layer, "AcDbCircle")?;
                return self.numbers(&[(10, centre.x), (20, centre.y), (30, 0.0), (40, radius)]);
            }
            let begin = u * from.cos() + v * from.sin();
            let begin = begin.y.atan2(begin.x);
            let [a, b] = counter_clockwise(begin, sweep * u.perp(v).signum());
            self.head("ARC", layer, "AcDbCircle")?;
            self.numbers(&[(10, centre.x), (20, centre.y), (30, 0.0), (40, radius)])?;
            self.texts(&[(100, "AcDbArc")])?;
            return self.numbers(&[(50, a.to_degrees()), (51, b.to_degrees())]);
        }
        // The axes of the ellipse, from conjugate half-diameters.
        let svd = Matrix2::from_columns(&[*u, *v]).svd(true, false);
        let (Some(axes), [major, minor]) = (svd.u, [svd.singular_values[0], svd.singular_values[1]]) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "an ellipse has no axes"));
        };
        if minor <= FLAT * major {
            // A segment, there and back.
            let axis: Vector2<f64> = axes.column(0).into();
            let turning = v.dot(&axis).atan2(u.dot(&axis));
            let along = |t: f64| centre + u * t.cos() + v * t.sin();
            let (low, high) = (from.min(from + sweep), from.max(from + sweep));
            let first = ((low - turning) / PI).ceil() as i64;
            let turns = (first..first + 5).map(|k| turning + k as f64 * PI).filter(|t| *t > low && *t < high);
            let stops: Vec<Corner> = std::iter::once(low).chain(turns).map(|t| (along(t), 0.0)).collect();
            return self.polyline(layer, &stops, Some(along(high)), false);
        }
        let major_axis: Vector2<f64> = axes.column(0) * major;
        let across = Vector2::new(-axes[(1, 0)], axes[(0, 0)]);
        let begin = u * from.cos() + v * from.sin();
        let begin = (begin.dot(&across) / minor).atan2(begin.dot(&major_axis) / (major * major));
        let [a, b] = if whole { [0.0, TAU] } else { counter_clockwise(begin, sweep * u.perp(v).signum()) };
        self.head("ELLIPSE", layer, "AcDbEllipse")?;
        self.numbers(&[(10, centre.x), (20, centre.y), (30, 0.0), (11, major_axis.x), (21, major_axis.y), (31, 0.0)])?;
        self.numbers(&[(40, minor / major), (41, a), (42, b)])
    }
}

/// Below this ratio of its axes an ellipse is a segment: the format asks for more than 1e-6.
const FLAT: f64 = 1e-6;

/// Half-diameters that differ by less, as a share, are those of a circle.
const ROUND: f64 = 1e-12;

fn circle_radius(u: &Vector2<f64>, v: &Vector2<f64>) -> Option<f64> {
    let radius = u.norm();
    let round = (radius - v.norm()).abs() <= ROUND * radius && u.dot(v).abs() <= ROUND * radius * radius;
    round.then_some(radius)
}

fn counter_clockwise(begin: f64, sweep: f64) -> [f64; 2] {
    if sweep > 0.0 { [begin, begin + sweep] } else { [begin + sweep, begin] }
}

/// A corner of a polyline, and the bulge of the curve that begins there.
type Corner = (Point2<f64>, f64);

/// Where each curve begins, with its bulge, and where the last one ends; `None` if they are not all segments and arcs of circles, each
/// of which begins where the one before ends.
fn corners(curves: &[Curve]) -> Option<(Vec<Corner>, Point2<f64>)> {
    let mut out: Vec<Corner> = Vec::new();
    let mut end: Option<Point2<f64>> = None;
    for curve in curves {
        let [from, to] = curve.ends();
        // Arcs of polylines keep their ends but for rounding.
        let size = from.coords.norm().max(to.coords.norm());
        if end.is_some_and(|end| (end - from).norm() > MEET * size) {
            return None;
        }
        match curve {
            Curve::Line { .. } => out.push((from, 0.0)),
            Curve::Arc { centre, u, v, from: begin, sweep } => {
                circle_radius(u, v).filter(|_| sweep.abs() < TAU)?;
                // In halves: a whole turn has no bulge.
                let half = 0.5 * sweep;
                let bulge = (0.25 * half).tan() * u.perp(v).signum();
                let middle = begin + half;
                out.extend([(from, bulge), (centre + u * middle.cos() + v * middle.sin(), bulge)]);
            }
            Curve::Spline { .. } => return None,
        }
        end = Some(to);
    }
    Some((out, end?))
}

/// Curves meet where their ends are this near, as a share of their coordinates.
const MEET: f64 = 1e-9;
