//! A drawing: entities on layers, as plain data.

use super::curve::Curve;

/// A piece of a drawing: curves, each of which begins where the one before ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Entity {
    /// What it is called in the file: `LINE`, `SPLINE`, `path`.
    pub kind: String,
    /// The layer it is on.
    pub layer: String,
    /// The line of the file where it begins; 0 where there is no file.
    pub line: u64,
    /// Its curves.
    pub curves: Vec<Curve>,
    /// Whether a segment leads from the last end to the first begin.
    pub closed: bool,
}

/// The entities of a drawing, in millimetres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// In the order of the file.
    pub entities: Vec<Entity>,
    /// What the file has that is not drawn: kind, and how many, by name.
    pub skipped: Vec<(String, usize)>,
    /// How many millimetres the unit of the file is; `None` if the file does not say, and millimetres were taken.
    pub unit_mm: Option<f64>,
}

impl Drawing {
    /// Adds an entity of some curves.
    pub fn add(&mut self, layer: &str, curves: impl IntoIterator<Item = Curve>) {
        let (kind, layer, curves) = ("curve".to_owned(), layer.to_owned(), curves.into_iter().collect());
        self.entities.push(Entity { kind, layer, line: 0, curves, closed: false });
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
        self.skipped.iter().map(|(_, count)| count).sum()
    }
}
