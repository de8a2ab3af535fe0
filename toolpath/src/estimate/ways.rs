//! Ways between curves, by the regions that the curves fill.
//!
//! A curve begins and ends anywhere in its region, each place as likely as another by area. From the end of one the nozzle goes to the curve
//! of the layer whose nearer end is nearest, and after the last one to the next layer. Where a sample stands for several layers, these all
//! have its regions.

use super::random::Random;
use super::region::Region;
use nalgebra::Point3;

/// How often each sample is travelled, at least: each time with other ends.
const MIN_ROUNDS: f64 = 8.0;

/// And at most: the mean of a thousand random ways is within some hundredths of what more would give.
const MAX_ROUNDS: f64 = 1000.0;

/// All ways between curves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ways {
    pub curves: f64,
    pub length_mm: f64,
}

/// The ways between the curves of layers, each of which stands for so many.
pub(super) fn between(layers: &[Vec<Region>], each: f64) -> Ways {
    let (mut ways, mut random) = (Ways::default(), Random::new(0));
    let rounds = each.ceil().clamp(MIN_ROUNDS, MAX_ROUNDS) as usize;
    let mut at: Option<Point3<f64>> = None;
    for regions in layers {
        ways.curves += each * regions.iter().map(|region| region.curves).sum::<f64>();
        let mut length_mm = 0.0;
        for _ in 0..rounds {
            let mut ends: Vec<[Point3<f64>; 2]> = Vec::new();
            for region in regions {
                ends.extend((0..region.curves.round() as usize).map(|_| [(); 2].map(|()| region.place(&mut random))));
            }
            length_mm += travelled(ends, &mut at);
        }
        ways.length_mm += length_mm * each / rounds as f64;
    }
    ways
}

/// The length of the ways to and between curves, from where the nozzle is, which moves on.
fn travelled(mut ends: Vec<[Point3<f64>; 2]>, at: &mut Option<Point3<f64>>) -> f64 {
    let mut length = 0.0;
    while !ends.is_empty() {
        let from = at.unwrap_or(ends[0][0]);
        let near = |ends: &[Point3<f64>; 2]| (ends[0] - from).norm().min((ends[1] - from).norm());
        let nearest = (0..ends.len()).min_by(|&a, &b| near(&ends[a]).total_cmp(&near(&ends[b]))).unwrap_or(0);
        let [one, other] = ends.swap_remove(nearest);
        let turns = (other - from).norm() < (one - from).norm();
        length += near(&[one, other]);
        *at = Some(if turns { one } else { other });
    }
    length
}
