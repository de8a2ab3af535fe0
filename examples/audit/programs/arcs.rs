//! Arcs of G2 and G3 as chords, in the plane of x and y, with a height that goes on evenly.

use nalgebra::Point3;
use std::f64::consts::TAU;

/// No chord is farther from its arc than this, in millimetres: a hundredth of thin beads.
const CHORD_MM: f64 = 0.003;
/// Radii at both ends may differ by this, in millimetres, or by that share: digits of files.
const RADIUS_MM: f64 = 0.05;
const RADIUS_SHARE: f64 = 0.01;

/// Where the centre is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Centre {
    /// So far from the begin.
    Offset([f64; 2]),
    /// At this radius from both ends; negative for the longer arc.
    Radius(f64),
}

/// Places along an arc, its end last.
///
/// # Errors
/// Why there is no such arc.
pub fn chords(from: Point3<f64>, to: Point3<f64>, centre: Centre, clockwise: bool) -> Result<Vec<Point3<f64>>, String> {
    let [i, j] = match centre {
        Centre::Offset(offset) => offset,
        Centre::Radius(radius) => by_radius(&from, &to, radius, clockwise)?,
    };
    let radius = i.hypot(j);
    let (x, y) = (from.x + i, from.y + j);
    let end = (to.x - x).hypot(to.y - y);
    if radius <= 0.0 || (end - radius).abs() > RADIUS_MM.max(RADIUS_SHARE * radius) {
        return Err(format!(
            "the arc begins {radius:.3} mm from its centre and ends {end:.3} mm from it: I, J or R do not fit"
        ));
    }
    let [begin, last] = [(from.y - y).atan2(from.x - x), (to.y - y).atan2(to.x - x)];
    let turn = if clockwise { begin - last } else { last - begin };
    let is_whole = (to.x - from.x).hypot(to.y - from.y) <= 1e-9;
    let turn = if is_whole { TAU } else { turn.rem_euclid(TAU) };
    let step = 2.0 * (1.0 - (CHORD_MM / radius).min(1.0)).acos();
    let count = (turn / step).ceil().clamp(1.0, 1e5) as u32;
    let sense = if clockwise { -1.0 } else { 1.0 };
    let at = |k: u32| {
        let share = f64::from(k) / f64::from(count);
        let (sin, cos) = (begin + sense * turn * share).sin_cos();
        let size = radius + (end - radius) * share;
        Point3::new(x + size * cos, y + size * sin, from.z + (to.z - from.z) * share)
    };
    Ok((1..count).map(at).chain([to]).collect())
}

fn by_radius(from: &Point3<f64>, to: &Point3<f64>, radius: f64, clockwise: bool) -> Result<[f64; 2], String> {
    let [x, y] = [to.x - from.x, to.y - from.y];
    let chord = x.hypot(y);
    let height = radius * radius - 0.25 * chord * chord;
    if chord <= 0.0 || height < -RADIUS_MM * radius.abs() {
        return Err(format!("an arc of the radius {radius} does not go over {chord:.3} mm"));
    }
    // To the left of the way for arcs against the clock that are less than half a turn.
    let left = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    let aside = left * height.max(0.0).sqrt() / chord;
    Ok([0.5 * x - y * aside, 0.5 * y + x * aside])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(from: Point3<f64>, places: &[Point3<f64>]) -> f64 {
        let ends: Vec<Point3<f64>> = [&[from], places].concat();
        ends.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    #[test]
    fn lengths_are_those_of_circles() {
        let (from, to) = (Point3::new(10.0, 0.0, 0.0), Point3::new(0.0, 10.0, 0.0));
        let quarter = TAU * 2.5;
        let of = |to: Point3<f64>, centre: Centre, clockwise: bool| {
            length(from, &chords(from, to, centre, clockwise).unwrap())
        };
        let round = Centre::Offset([-10.0, 0.0]);
        assert!((of(to, round, false) - quarter).abs() < 0.01);
        assert!((of(to, round, true) - 3.0 * quarter).abs() < 0.02);
        assert!((of(from, round, false) - 4.0 * quarter).abs() < 0.03);
        assert!((of(to, Centre::Radius(10.0), false) - quarter).abs() < 0.01);
        assert!((of(to, Centre::Radius(-10.0), false) - 3.0 * quarter).abs() < 0.02);
        // Clockwise with the short radius: the other quarter, about (10, 10).
        let other = chords(from, to, Centre::Radius(10.0), true).unwrap();
        assert!(other.iter().all(|at| ((at.x - 10.0).hypot(at.y - 10.0) - 10.0).abs() < 1e-9));
        assert!(chords(from, to, Centre::Offset([5.0, 5.0]), false).is_err());
        assert!(chords(from, to, Centre::Radius(2.0), false).is_err());
    }
}
