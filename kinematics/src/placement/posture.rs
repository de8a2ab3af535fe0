//! The best posture of a waypoint in a workcell.

use super::part::{Assessment, PlaceError};
use crate::limits::JointLimits;
use crate::scene::Scene;
use crate::setup::Waypoint;
use crate::workcell::{FreeRange, Workcell};
use std::f64::consts::TAU;

/// Assesses waypoints in a workcell by their best posture: the one with the greatest clearance up to a bound, then the greatest
/// manipulability, among all branches at samples of the free parameters.
///
/// ```
/// use curvlay_kinematics::nalgebra::{Point3, Vector3};
/// use curvlay_kinematics::scene::Scene;
/// use curvlay_kinematics::workcell::AnyWorkcell;
/// use curvlay_kinematics::{BestPosture, Waypoint, best_place, place_grid};
/// use std::ops::ControlFlow::Continue;
/// # #[cfg(feature = "serde")] {
/// # let file = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/cells/ur3.json"))?;
/// let AnyWorkcell::Six(workcell) = AnyWorkcell::from_json(file.as_slice())? else { return Err("it has a table".into()) };
/// let mut model = workcell.equipment().scene(100.0);
/// // The nozzle and what it prints on are for the rules of gouging.
/// model.allowed = ["nozzle", "hot end"].map(|name| [name.into(), "plate".into()]).into();
/// let scene = Scene::new(model)?;
/// let postures = BestPosture::new(&workcell, &scene, [24], 10.0)?;
/// let high = Waypoint { position: Point3::new(30.0, 0.0, 80.0), axis: Vector3::z_axis() };
/// let best = best_place(&place_grid(20.0, 1, 1)?, &[high], 5.0, |_, at| postures.assess(at), &|_| Continue(()))?;
/// assert!(best.unreachable.is_empty());
/// # }
/// # use curvlay_kinematics::workcell::Workcell;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BestPosture<'a, W, const N: usize, const F: usize> {
    workcell: &'a W,
    scene: &'a Scene,
    samples: [u32; F],
    max_clearance: f64,
    limits: JointLimits<N>,
}

/// More postures than this for a waypoint are a mistake: each costs some microseconds.
const MAX_SAMPLES: f64 = 1e6;

impl<'a, const N: usize, const F: usize, W: Workcell<N, F>> BestPosture<'a, W, N, F> {
    /// # Arguments
    /// * `scene`: of the workcell. What is in it does not move with the place of the part, so leave the part out; allow the pairs
    ///   that may touch while the nozzle prints.
    /// * `samples`: of each free parameter, at most a million together: even over a turn, or from one end of the range to the other.
    /// * `max_clearance`: in millimetres; more is not looked for. A posture with more clearance is rated by its manipulability.
    ///
    /// # Errors
    /// [`PlaceError::Option`] names the argument.
    pub fn new(workcell: &'a W, scene: &'a Scene, samples: [u32; F], max_clearance: f64) -> Result<Self, PlaceError> {
        if samples.contains(&0) {
            return Err(PlaceError::Option { what: "samples", value: 0.0, must: "at least 1 each" });
        }
        // In f64, where no product overflows.
        let postures: f64 = samples.iter().map(|&samples| f64::from(samples)).product();
        if postures > MAX_SAMPLES {
            let must = "at most a million together";
            return Err(PlaceError::Option { what: "samples", value: postures, must });
        }
        if !(max_clearance.is_finite() && max_clearance > 0.0) {
            let must = "finite and above 0";
            return Err(PlaceError::Option { what: "max_clearance", value: max_clearance, must });
        }
        Ok(BestPosture { workcell, scene, samples, max_clearance, limits: *workcell.limits() })
    }

    /// The same with other limits, such as stops that motions keep away from.
    pub fn within(self, limits: JointLimits<N>) -> Self {
        BestPosture { limits, ..self }
    }

    /// What a waypoint is worth, and `None` where it has no posture within the limits that keeps the margin of the scene. The
    /// clearance is what remains beyond that margin.
    ///
    /// # Cost
    /// A distance query for each posture within the limits, but for those that have less manipulability than one with full
    /// clearance: 0.5 to 0.9 ms a waypoint for the six-axis cells of the examples and 24 tool angles, so 150 waypoints at 49
    /// places took 2 to 3 s.
    pub fn assess(&self, waypoint: &Waypoint) -> Option<Assessment> {
        self.find(waypoint).map(|(assessment, _)| assessment)
    }

    /// The same with the joints of the posture.
    pub fn find(&self, waypoint: &Waypoint) -> Option<(Assessment, [f64; N])> {
        let ranges = self.workcell.free();
        // A range of a single value, such as the tilt of a table that only turns, has one sample.
        let counts: [u64; F] = std::array::from_fn(|f| match ranges[f] {
            FreeRange::Within(min, max) if max <= min => 1,
            FreeRange::Turn | FreeRange::Within(..) => u64::from(self.samples[f]),
        });
        let mut best: Option<(Assessment, [f64; N])> = None;
        for sample in 0..counts.iter().product() {
            let mut rest = sample;
            let free = std::array::from_fn(|f| {
                let samples = counts[f];
                let share = |parts: u64| (rest % samples) as f64 / parts as f64;
                let value = match ranges[f] {
                    FreeRange::Turn => TAU * share(samples),
                    FreeRange::Within(min, max) if samples == 1 => 0.5 * (min + max),
                    FreeRange::Within(min, max) => min + (max - min) * share(samples - 1),
                };
                rest /= samples;
                value
            });
            self.workcell.solutions(waypoint, &free, &mut |_, joints| {
                // Stops may leave a joint only images beyond half a turn.
                let Some(joints) = self.limits.nearest_image(&joints, &joints) else { return };
                if let Some(found) = self.better(&joints, best.map(|(best, _)| best)) {
                    best = Some((found, joints));
                }
            });
        }
        best
    }

    /// What a posture is worth, if that is more than the best so far.
    fn better(&self, joints: &[f64; N], best: Option<Assessment>) -> Option<Assessment> {
        let quality = self.workcell.manipulability(joints);
        let known = best.map_or((0.0, f64::NEG_INFINITY), |best| (best.clearance, best.quality));
        if known.0 >= self.max_clearance && quality <= known.1 {
            return None;
        }
        let margin = self.scene.margin();
        let posture = self.workcell.scene_posture(joints);
        let near = self.scene.clearance(&posture, margin + self.max_clearance).ok()?;
        let clearance = near.map_or(self.max_clearance, |near| near.nearest.distance - margin);
        let is_better = clearance > known.0 || (clearance >= known.0 && quality > known.1);
        (clearance > 0.0 && is_better).then_some(Assessment { clearance, quality })
    }
}
