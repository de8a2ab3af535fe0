//! A drawing: entities on layers, as plain data.

use super::curve::{Affine, Curve};
use super::skipped::Skipped;

/// A piece of a drawing: curves, each of which begins where the one before ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Entity {
    /// What it is called in the file: `LINE`, `SPLINE`, `path`.
    pub kind: String,
    /// The layer it is on.
    pub layer: String,
    /// The line of the file where it begins, or the byte in a binary file; 0 where there is no file.
    pub line: u64,
    /// Its curves.
    pub curves: Vec<Curve>,
    /// Whether a segment leads from the last end to the first begin.
    pub closed: bool,
    /// The path with several outlines that it is a part of, in SVG; `None`: what it encloses is filled, whatever else is drawn.
    pub fill: Option<PathFill>,
}

/// The path of which an outline is a part, and what the outlines of that path fill together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathFill {
    /// Number of the path: the same for all its outlines, and for no others.
    pub path: u32,
    /// What its outlines fill.
    pub rule: FillRule,
}

/// What outlines fill together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FillRule {
    /// What they wind around, in one direction more often than in the other.
    NonZero,
    /// What an odd number of them encloses.
    EvenOdd,
}

/// The entities of a drawing, in millimetres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// In the order of the file.
    pub entities: Vec<Entity>,
    /// What the file has that is not drawn.
    pub skipped: Vec<Skipped>,
    /// What the reader assumed, a sentence each.
    pub notes: Vec<String>,
    /// How many millimetres the unit of the file is; `None` if the file does not say, and one was assumed.
    pub unit_mm: Option<f64>,
}

impl Drawing {
    /// Adds an entity of some curves.
    pub fn add(&mut self, layer: &str, curves: impl IntoIterator<Item = Curve>) {
        let (kind, layer, curves) = ("curve".to_owned(), layer.to_owned(), curves.into_iter().collect());
        self.entities.push(Entity { kind, layer, line: 0, curves, closed: false, fill: None });
    }

    /// Takes a unit of the file for so many millimetres: everything is scaled from what was taken for it.
    /// ```
    /// use curvlay_toolpath::drawing::{Curve, Drawing};
    /// use curvlay_toolpath::nalgebra::Point2;
    /// let mut drawing = Drawing::default();
    /// drawing.add("RIM", [Curve::circle(Point2::new(2.0, 0.0), 1.0, 0.0, std::f64::consts::TAU)]);
    /// drawing.set_unit(10.0);
    /// assert_eq!(drawing.entities[0].curves[0].ends()[0], Point2::new(30.0, 0.0));
    /// ```
    pub fn set_unit(&mut self, unit_mm: f64) {
        let map = Affine::scale(unit_mm / self.unit_mm.unwrap_or(1.0));
        for curve in self.entities.iter_mut().flat_map(|entity| &mut entity.curves) {
            *curve = curve.mapped(&map);
        }
        self.unit_mm = Some(unit_mm);
    }

    /// The layers that have entities, by name, and how many.
    /// ```
    /// use curvlay_toolpath::drawing::Drawing;
    /// let mut drawing = Drawing::default();
    /// ["RIM", "HUB", "RIM"].map(|layer| drawing.add(layer, []));
    /// assert_eq!(drawing.layers(), [("HUB".to_owned(), 1), ("RIM".to_owned(), 2)]);
    /// ```
    pub fn layers(&self) -> Vec<(String, usize)> {
        let mut names: Vec<&str> = self.entities.iter().map(|entity| entity.layer.as_str()).collect();
        names.sort_unstable();
        names.chunk_by(|a, b| a == b).map(|same| (same[0].to_owned(), same.len())).collect()
    }

    /// Entities that are not drawn.
    pub fn skipped_count(&self) -> usize {
        self.skipped.iter().fold(0, |sum, skipped| sum.saturating_add(skipped.count))
    }
}
