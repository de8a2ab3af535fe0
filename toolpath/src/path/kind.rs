//! What a piece of bead is for, and runs of a kind along a curve.

use super::points::SurfacePath;

/// What a piece of bead is for. Machines lay walls slower than what is inside, and viewers show each kind in its own colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum BeadKind {
    /// Along the boundary of a layer: of a layer that is filled solid the outermost contour, of others all contours that were asked
    /// for.
    Wall,
    /// The inside of a layer that is filled solid.
    #[default]
    Solid,
    /// Solid because the layer is near the outside of the part: bottoms and tops over and under sparse infill.
    Skin,
    /// A skin over sparse infill, which is no ground. What lies between two bridges and is no longer than five beads is one of them, and so
    /// with what lies between two skins: machines change fan and speed at each.
    Bridge,
    /// Sparse infill.
    Infill,
    /// Support: not of the part, to be broken off ([`FilledLayer::with_support`](crate::fill::FilledLayer::with_support)).
    Support,
    /// Sparse infill of support.
    SparseSupport,
    /// Support over its own sparse infill, as a bridge is over that of the part.
    SupportBridge,
}

impl BeadKind {
    /// Whether it is sparse infill, of the part or of support: it lies on something here and there only.
    pub fn is_sparse(self) -> bool {
        matches!(self, BeadKind::Infill | BeadKind::SparseSupport)
    }

    /// Whether it goes over sparse infill, of the part or of support: it lies on something here and there only.
    pub fn is_bridge(self) -> bool {
        matches!(self, BeadKind::Bridge | BeadKind::SupportBridge)
    }

    /// Whether it is not of the part.
    pub fn is_support(self) -> bool {
        matches!(self, BeadKind::Support | BeadKind::SparseSupport | BeadKind::SupportBridge)
    }
}

impl SurfacePath {
    /// Runs of a kind between two of another that are no longer than `most`, in millimetres, become of that kind.
    pub(crate) fn absorb(&mut self, kind: BeadKind, into: BeadKind, most: f64) {
        let count = self.points.len();
        let Some(other) = self.points.iter().position(|point| point.kind != kind) else { return };
        // All around a closed curve from a point of another kind, along an open one from its start.
        let (start, steps) = if self.closed { (other, count + 1) } else { (0, count) };
        // The first point of the run, and its length from the point before.
        let mut run: Option<(usize, f64)> = None;
        let mut last = kind;
        for step in 0..steps {
            let [before, here] = [step + count - 1, step].map(|step| (start + step) % count);
            let leg = (self.points[here].at.position - self.points[before].at.position).norm();
            let of = self.points[here].kind;
            if of == kind {
                let (first, length) = run.unwrap_or((step, if last == into { 0.0 } else { f64::INFINITY }));
                run = Some((first, length + leg));
            } else if let Some((first, length)) = run.take()
                && of == into
                && length + leg <= most
            {
                (first..step).for_each(|step| self.points[(start + step) % count].kind = into);
            }
            last = of;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::points::PathPoint;
    use super::*;
    use crate::mesh::SurfacePoint;
    use nalgebra::Point3;

    /// Points a millimetre apart: `b` is a bridge, `s` a skin, `w` a wall.
    fn path(kinds: &str, closed: bool) -> SurfacePath {
        let kind = |letter| match letter {
            'b' => BeadKind::Bridge,
            's' => BeadKind::Skin,
            _ => BeadKind::Wall,
        };
        // Closed ones are round, so that the way from the end to the start is a millimetre as well.
        let turn = std::f64::consts::TAU / kinds.len() as f64;
        let radius = 0.5 / (turn / 2.0).sin();
        let position = |k: f64| match closed {
            true => Point3::new(radius * (k * turn).cos(), radius * (k * turn).sin(), 0.0),
            false => Point3::new(k, 0.0, 0.0),
        };
        let at = |k: usize| SurfacePoint { triangle: 0, barycentric: [1.0, 0.0, 0.0], position: position(k as f64) };
        let points =
            kinds.chars().enumerate().map(|(k, letter)| PathPoint { at: at(k), width: 0.5, kind: kind(letter) });
        SurfacePath { points: points.collect(), closed, region: 0 }
    }

    fn absorbed(kinds: &str, closed: bool) -> String {
        let mut path = path(kinds, closed);
        path.absorb(BeadKind::Skin, BeadKind::Bridge, 3.5);
        let letter = |point: &PathPoint| match point.kind {
            BeadKind::Bridge => 'b',
            BeadKind::Skin => 's',
            _ => 'w',
        };
        path.points.iter().map(letter).collect()
    }

    #[test]
    fn short_runs_between_two_of_a_kind_are_of_that_kind() {
        // Two points between are 3 mm from bridge to bridge, three are 4 mm.
        assert_eq!(absorbed("bssbbsssbbsb", false), "bbbbbsssbbbb");
        // At the ends of an open curve, and beside a wall, there is nothing on one side.
        assert_eq!(absorbed("ssbbwsbbsswss", false), "ssbbwsbbsswss");
        // A closed curve has no ends.
        assert_eq!(absorbed("sbbbbs", true), "bbbbbb");
        assert_eq!(absorbed("ssbbbbs", true), "ssbbbbs");
        assert_eq!(absorbed("ssss", true), "ssss");
        assert_eq!(absorbed("bbbb", true), "bbbb");
    }
}
