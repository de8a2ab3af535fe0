//! Short and narrow curves that later beads lie on.

use super::segments::Segments;
use crate::mesh::on_segment;
use crate::path::SurfacePath;
use nalgebra::Point3;

/// A place of a bead, and how near the middle of an earlier one has to be to carry it, in millimetres.
pub(crate) struct Place {
    pub at: Point3<f64>,
    pub reach: f64,
}

/// For each curve, short or narrow, whether a place lies on it and on none of the curves that are kept.
pub(crate) fn carriers(kept: &[SurfacePath], left: &[SurfacePath], places: &[Place]) -> Vec<bool> {
    let most = places.iter().map(|place| place.reach).fold(0.0, f64::max);
    let mut carries = vec![false; left.len()];
    if most <= 0.0 {
        return carries;
    }
    let [kept_near, left_near] = [kept, left].map(|paths| segments(paths, most));
    let within = |paths: &[SurfacePath], [number, k]: [u32; 2], place: &Place| {
        let line = paths[number as usize].segment(k as usize).map(|point| point.at.position);
        (on_segment(line, place.at) - place.at).norm() <= place.reach
    };
    for place in places {
        let on: Vec<u32> =
            left_near.near(place.at).filter(|&name| within(left, name, place)).map(|[number, _]| number).collect();
        if on.is_empty() || kept_near.near(place.at).any(|name| within(kept, name, place)) {
            continue;
        }
        on.into_iter().for_each(|number| carries[number as usize] = true);
    }
    carries
}

/// Segments that are looked up within a reach.
fn segments(paths: &[SurfacePath], reach: f64) -> Segments {
    let mut segments = Segments::within(reach, paths.iter());
    segments.add_all(paths);
    segments
}
