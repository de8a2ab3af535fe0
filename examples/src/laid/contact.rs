//! A nozzle against what is laid so far.
//!
//! Candidates are the beads from which the nozzle is less than a margin away; while it has moved less than the margin since they were collected, no other bead can
//! count, and of the candidates only those that were less than the motion since away.

use super::beads::{Beads, Capsule, Layer};
use super::nozzle::{Nozzle, NozzlePose};
use nalgebra::{Point3, Vector3};

/// Motion after which candidates are collected again, in millimetres.
const MARGIN_MM: f64 = 2.0;
/// Places along a capsule at which the distance is computed, at least, beside its begin: they are a radius apart at most.
const MIN_PLACES: f64 = 4.0;

/// What is laid, and a nozzle.
#[derive(Clone, Debug)]
pub struct NozzleInBeads {
    nozzle: Nozzle,
    /// Depth that is allowed: a share of the bead's height.
    allowed: f64,
    beads: Beads,
    layer: Layer,
    /// Where candidates were collected, and each with the motion that it takes at least until it counts.
    from: Option<NozzlePose>,
    candidates: Vec<(f64, u32)>,
    found: Vec<u32>,
    /// Beads up to this number may be candidates; later ones are always looked at.
    collected: usize,
}

impl NozzleInBeads {
    /// Nothing is laid. `allowed`: depth in a bead that does not count, as a share of its height.
    pub fn new(nozzle: Nozzle, allowed: f64) -> Self {
        NozzleInBeads {
            nozzle,
            allowed,
            beads: Beads::default(),
            layer: Layer::default(),
            from: None,
            candidates: Vec::new(),
            found: Vec::new(),
            collected: 0,
        }
    }

    /// How many capsules are laid.
    pub fn len(&self) -> usize {
        self.beads.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How deep the nozzle is in the plate z = 0; negative above it.
    pub fn below_plate(&self, pose: &NozzlePose) -> f64 {
        -self.nozzle.lowest(pose)
    }

    /// The tip has come to a place: it lays a bead of a height on the way there, or none.
    pub fn lay(&mut self, pose: &NozzlePose, height_mm: Option<f64>) {
        let ended = match height_mm {
            Some(height) => self.layer.go(pose.tip - pose.axis * (0.5 * height), 0.5 * height),
            None => self.layer.end(),
        };
        if let Some(capsule) = ended {
            self.beads.push(capsule);
        }
    }

    /// How much deeper the nozzle is in beads than is allowed.
    pub fn depth(&mut self, pose: &NozzlePose) -> f64 {
        let moved = match &self.from {
            Some(from) => {
                let turned = (pose.axis - from.axis).norm();
                (pose.tip - from.tip).norm() + turned * (self.nozzle.top + self.nozzle.block)
            }
            None => f64::INFINITY,
        };
        if moved >= MARGIN_MM {
            self.collect(pose);
            return self.deepest(pose, 0.0);
        }
        self.deepest(pose, moved)
    }

    fn deepest(&self, pose: &NozzlePose, moved: f64) -> f64 {
        let near = self.candidates.iter().filter(|(motion, _)| *motion <= moved).map(|(_, number)| *number as usize);
        let depth = |number: usize| {
            let capsule = self.beads.at(number);
            let accepted = 2.0 * self.allowed * capsule.radius;
            gap_within(&self.nozzle, pose, capsule, -accepted).map_or(0.0, |gap| -gap - accepted)
        };
        near.chain(self.collected..self.beads.len()).map(depth).fold(0.0, f64::max)
    }

    fn collect(&mut self, pose: &NozzlePose) {
        let [low, high] = self.nozzle.bounds(pose);
        // The axis of a bead is farther in than the bead.
        let margin = Vector3::repeat(MARGIN_MM + self.beads.max_radius());
        self.found.clear();
        self.beads.within(&[low - margin, high + margin], &mut self.found);
        let near = self.found.iter().filter_map(|&number| {
            let capsule = self.beads.at(number as usize);
            let accepted = 2.0 * self.allowed * capsule.radius;
            let motion = accepted + least_gap(&self.nozzle, pose, capsule, MARGIN_MM - accepted)?;
            Some((motion, number))
        });
        self.candidates.clear();
        self.candidates.extend(near);
        self.collected = self.beads.len();
        self.from = Some(*pose);
    }
}

/// A bound below the distance of a capsule from the nozzle, if it is not more than `most`: all of the nozzle is above the plane of its tip, and distances change
/// by no more than the place does.
fn least_gap(nozzle: &Nozzle, pose: &NozzlePose, capsule: &Capsule, most: f64) -> Option<f64> {
    let ([from, to], radius) = (capsule.ends, capsule.radius);
    let height = |end: Point3<f64>| (end - pose.tip).dot(&pose.axis);
    let below = -height(from).max(height(to)) - radius;
    if below > most {
        return None;
    }
    let (middle, half) = (from + (to - from) * 0.5, 0.5 * (to - from).norm());
    let gap = below.max(nozzle.distance(pose, &middle) - half - radius);
    (gap <= most).then_some(gap)
}

/// How far a capsule is from the nozzle, if that is not more than `most`; negative where they touch.
fn gap_within(nozzle: &Nozzle, pose: &NozzlePose, capsule: &Capsule, most: f64) -> Option<f64> {
    least_gap(nozzle, pose, capsule, most)?;
    let ([from, to], radius) = (capsule.ends, capsule.radius);
    let places = ((to - from).norm() / radius).ceil().max(MIN_PLACES);
    let at = |k: u32| nozzle.distance(pose, &(from + (to - from) * (f64::from(k) / places)));
    let gap = (0..=places as u32).map(at).fold(f64::INFINITY, f64::min) - radius;
    (gap <= most).then_some(gap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn nozzle() -> Nozzle {
        Nozzle::new([1.0, std::f64::consts::FRAC_PI_4, 8.0, 20.0, 60.0]).unwrap()
    }

    /// By the same places along the axis, without any short cut.
    fn slow_depth(pose: &NozzlePose, capsule: &Capsule) -> f64 {
        let [from, to] = capsule.ends;
        let count = ((to - from).norm() / capsule.radius).ceil().max(4.0);
        let at = |k: u32| nozzle().distance(pose, &(from + (to - from) * (f64::from(k) / count)));
        capsule.radius - (0..=count as u32).map(at).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(48) })]

        /// The twin looks at all beads at all ticks.
        #[test]
        fn agrees_with_all_beads(steps in prop::collection::vec((prop::array::uniform3(-1f64..1.0), -0.02f64..0.02), 50..400)) {
            let mut contact = NozzleInBeads::new(nozzle(), 0.0);
            let (mut slow, mut layer): (Vec<Capsule>, Layer) = (Vec::new(), Layer::default());
            let (mut at, mut lean) = (Point3::new(0.0, 0.0, 10.0), 0.0f64);
            for (k, (step, turn)) in steps.iter().enumerate() {
                at += Vector3::from(*step);
                lean += turn;
                let pose = NozzlePose { tip: at, axis: Vector3::new(lean.sin(), 0.0, lean.cos()) };
                let expected = slow.iter().map(|capsule| slow_depth(&pose, capsule)).fold(0.0, f64::max);
                let found = contact.depth(&pose);
                prop_assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
                contact.lay(&pose, Some(0.6));
                slow.extend(layer.go(pose.tip - pose.axis * 0.3, 0.3));
            }
        }
    }
}
