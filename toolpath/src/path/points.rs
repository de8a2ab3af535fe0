//! Curves on a layer, point by point.

use super::kind::BeadKind;
use crate::mesh::SurfacePoint;
use nalgebra::Point3;

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathPoint {
    /// Where it is on the surface.
    pub at: SurfacePoint,
    /// Width of the bead here, in millimetres.
    pub width: f64,
    /// What it is for.
    pub kind: BeadKind,
}

/// A continuous curve on the surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePath {
    /// Points in order, along which material is laid without a break.
    pub points: Vec<PathPoint>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
    /// The region that it fills.
    pub region: u32,
}

impl SurfacePath {
    /// Length of the curve, in millimetres.
    pub fn length(&self) -> f64 {
        let step = |a: &PathPoint, b: &PathPoint| (b.at.position - a.at.position).norm();
        let steps = self.points.windows(2).map(|pair| step(&pair[0], &pair[1])).sum::<f64>();
        match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(first), Some(last)) => steps + step(last, first),
            _ => steps,
        }
    }

    /// How many segments it has; each begins at the point of its number.
    pub(crate) fn segments(&self) -> usize {
        if self.closed { self.points.len() } else { self.points.len().saturating_sub(1) }
    }

    /// Both ends of a segment.
    pub(crate) fn segment(&self, k: usize) -> [&PathPoint; 2] {
        [&self.points[k], &self.points[(k + 1) % self.points.len()]]
    }

    /// The places and widths of its points; of a closed curve the first stands at the end once more.
    pub fn line(&self) -> (Vec<Point3<f64>>, Vec<f64>) {
        let closing = self.closed.then(|| self.points.first()).flatten();
        self.points.iter().chain(closing).map(|point| (point.at.position, point.width)).unzip()
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
