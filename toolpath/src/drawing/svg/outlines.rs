//! Paths of an SVG file as entities: one for each outline.

use super::document::{Source, Sources};
use crate::drawing::curve::{Affine, Curve};
use crate::drawing::drawing::{Drawing, Entity, FillRule, PathFill};
use crate::drawing::skipped::Skips;
use nalgebra::{Matrix2, Point2, Vector2};
use std::collections::BTreeSet;
use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{Group, Node, Path};

/// Goes through the groups of a file.
pub(super) struct Walk<'a> {
    sources: &'a Sources,
    up: Affine,
    drawing: Drawing,
    skips: Skips,
    /// Ids of elements of which something was drawn, or not for a reason.
    seen: BTreeSet<String>,
    paths: u32,
    /// Groups that are clipped or masked.
    clipped: usize,
}

/// An outline of a path, and whether it is closed.
type Outline = (Vec<Curve>, bool);

impl<'a> Walk<'a> {
    pub fn new(sources: &'a Sources, up: Affine) -> Self {
        let (skips, seen) = (sources.skips.clone(), BTreeSet::new());
        Walk { sources, up, drawing: Drawing::default(), skips, seen, paths: 0, clipped: 0 }
    }

    /// The drawing, with what was not drawn.
    pub fn finish(mut self) -> Drawing {
        for id in self.sources.wanted.difference(&self.seen) {
            if let Some(source) = self.sources.shapes.get(id) {
                self.skips.add(&format!("{} (without extent, damaged, or hidden)", source.kind), source.place.clone());
            }
        }
        if self.clipped > 0 {
            let note = format!("clip paths and masks are not applied, what they cut off is drawn: {}", self.clipped);
            self.drawing.notes.push(note);
        }
        self.drawing.skipped = self.skips.into_list();
        self.drawing
    }

    /// # Arguments
    /// * `layer`: the innermost Inkscape layer, else the outermost group with an id.
    pub fn group(&mut self, group: &'a Group, layer: Option<&'a str>) {
        self.clipped += usize::from(group.clip_path().is_some() || group.mask().is_some());
        let id = Some(group.id()).filter(|id| !id.is_empty());
        let label = id.and_then(|id| self.sources.labels.get(id)).map(String::as_str);
        let layer = label.or(layer).or(id);
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group, layer),
                Node::Path(path) => self.path(path, layer.unwrap_or("0")),
                // Counted in the document: without fonts there is no text here.
                Node::Image(_) | Node::Text(_) => {}
            }
        }
    }

    fn path(&mut self, path: &Path, layer: &str) {
        let source = self.sources.shapes.get(path.id());
        self.seen.insert(path.id().to_owned());
        let (kind, place) = source.map_or(("path", ""), |source| (source.kind.as_str(), source.place.as_str()));
        if !path.is_visible() {
            return self.skips.add(&format!("{kind} (invisible)"), place.to_owned());
        }
        let outlines = self.outlines(path);
        let rule = path.fill().map(|fill| match fill.rule() {
            usvg::FillRule::NonZero => FillRule::NonZero,
            usvg::FillRule::EvenOdd => FillRule::EvenOdd,
        });
        // A single outline is filled by itself, unless it may cross itself to a hole.
        let together = rule.filter(|rule| outlines.len() > 1 || *rule == FillRule::EvenOdd);
        let fill = together.map(|rule| PathFill { path: self.paths, rule });
        self.paths += u32::from(fill.is_some());
        for (curves, closed) in outlines {
            if let Some(fault) = curves.iter().find_map(|curve| curve.drawable().err()) {
                self.skips.add(&format!("{kind} ({fault})"), place.to_owned());
                continue;
            }
            let closed = closed || (rule.is_some() && encloses(&curves));
            let line = source.map_or(0, |source: &Source| source.line);
            let (kind, layer) = (kind.to_owned(), layer.to_owned());
            self.drawing.entities.push(Entity { kind, layer, line, curves, closed, fill: fill.filter(|_| closed) });
        }
    }

    fn outlines(&self, path: &Path) -> Vec<Outline> {
        let t = path.abs_transform();
        let [sx, kx, tx, ky, sy, ty] = [t.sx, t.kx, t.tx, t.ky, t.sy, t.ty].map(f64::from);
        let map = self.up.after(&Affine { matrix: Matrix2::new(sx, kx, ky, sy), shift: Vector2::new(tx, ty) });
        let point = |p: Point| map.point(&Point2::new(f64::from(p.x), f64::from(p.y)));
        let mut all: Vec<Outline> = Vec::new();
        let (mut begin, mut at) = (Point2::origin(), Point2::origin());
        for segment in path.data().segments() {
            let curve = match segment {
                PathSegment::MoveTo(p) => {
                    (begin, at) = (point(p), point(p));
                    all.push((Vec::new(), false));
                    continue;
                }
                PathSegment::Close => {
                    if let Some((_, closed)) = all.last_mut() {
                        *closed = true;
                    }
                    at = begin;
                    continue;
                }
                PathSegment::LineTo(p) => Curve::Line { from: at, to: point(p) },
                PathSegment::QuadTo(a, p) => Curve::bezier(vec![at, point(a), point(p)]),
                PathSegment::CubicTo(a, b, p) => Curve::bezier(vec![at, point(a), point(b), point(p)]),
            };
            at = curve.ends()[1];
            match all.last_mut() {
                Some((curves, false)) => curves.push(curve),
                // Drawn on after it was closed: an outline of its own.
                _ => all.push((vec![curve], false)),
            }
        }
        all.retain(|(curves, _)| !curves.is_empty());
        all
    }
}

/// How far the points of a line may lie beside it, as a share of its length: single precision has seven digits.
const STRAIGHT: f64 = 1e-5;

/// Whether curves leave the straight line: only then their fill has an area.
fn encloses(curves: &[Curve]) -> bool {
    let points: Vec<Point2<f64>> = curves
        .iter()
        .flat_map(|curve| match curve {
            Curve::Spline { points, .. } => points.clone(),
            other => other.ends().to_vec(),
        })
        .collect();
    let Some(first) = points.first() else { return false };
    let farthest = points.iter().map(|p| p - first).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let Some(axis) = farthest.and_then(|axis| axis.try_normalize(0.0).map(|unit| (unit, axis.norm()))) else {
        return false;
    };
    points.iter().any(|p| (p - first).perp(&axis.0).abs() > STRAIGHT * axis.1)
}
