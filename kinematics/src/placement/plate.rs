//! Where a print stands on the plate of a workcell: in the middle, unless waypoints are out of reach there, or tight.

use super::part::{Assessment, PlaceError, best_place, place_grid};
use super::posture::BestPosture;
use super::sample::representative_waypoints;
use crate::progress::ProgressFn;
use crate::scene::{Mount, Scene, SceneError};
use crate::setup::Waypoint;
use crate::workcell::{PLATE, Workcell, nozzle_pairs};
use nalgebra::{Isometry3, Point3, Vector3};

/// How a place on the plate is chosen, for `F` free parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateOptions<const F: usize> {
    /// Samples of each free parameter at which postures are looked for, as of [`BestPosture::new`].
    pub samples: [u32; F],
    /// How far joints stay from their stops, in radians.
    pub stop_margin: f64,
    /// How far things keep apart, in millimetres.
    pub margin_mm: f64,
    /// Clearance beyond that from which a posture is not tight, in millimetres.
    pub comfortable_mm: f64,
    /// Distance that the part keeps from the edge of the plate, in millimetres, such as the width of a bead.
    pub rim_mm: f64,
    /// Waypoints that stand for the whole print.
    pub representatives: usize,
    /// How many millimetres a radian between directions counts among them: about what the wrist of an arm has to move.
    pub lever_mm: f64,
    /// Places from the middle of the plate to as far out as the part stays on it.
    pub steps: u32,
    /// Turns of the part at each place, where neither the last joint nor a table turns it, and the plate is no rectangle.
    pub turns: u32,
}

impl<const F: usize> PlateOptions<F> {
    /// With these samples: 0.5 mm apart and 9.5 mm more to be comfortable, as
    /// [`GrowingOptions`](crate::workcell::GrowingOptions); 120 waypoints, a lever of 150 mm, three places out, eight turns; no
    /// margin at stops, no rim.
    pub fn new(samples: [u32; F]) -> Self {
        PlateOptions {
            samples,
            stop_margin: 0.0,
            margin_mm: 2.0,
            comfortable_mm: 9.5,
            rim_mm: 0.0,
            representatives: 120,
            lever_mm: 150.0,
            steps: 3,
            turns: 8,
        }
    }
}

/// Why a place on a plate cannot be chosen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlateError {
    /// Waypoints or options that cannot be used.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The workcell is no scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Maps a part to the part frame so that the mean of its tips is in the middle of the plate, at its own height.
pub fn centred_on_plate<'a>(tips: impl IntoIterator<Item = &'a Point3<f64>>) -> Isometry3<f64> {
    let (mut sum, mut count) = (Vector3::zeros(), 0usize);
    for tip in tips {
        sum += tip.coords;
        count += 1;
    }
    let mean = sum / count.max(1) as f64;
    Isometry3::translation(-mean.x, -mean.y, 0.0)
}

/// Where a print stands on the plate of a workcell. The mean of its tips comes to the middle of the plate, or so near to it that
/// the fewest waypoints are without a posture, and the fewest tight: with the arm against itself, the plate, and whatever
/// stands there. The part itself is not looked at.
///
/// C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1, takes the middle.
///
/// # Arguments
/// * `waypoints`: of the whole print, in the part's own frame.
/// * `wanted_mm`: diameter of the plate where the workcell leaves it open.
/// * `progress`: as of [`best_place`]; may stop the work.
///
/// # Returns
/// What maps the part to the part frame of the workcell.
///
/// # Errors
/// [`PlateError`] names the waypoint or the option.
///
/// # Cost
/// That of choosing the waypoints (their number times [`PlateOptions::representatives`]) and of [`best_place`]: some seconds.
pub fn place_on_plate<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    waypoints: &[Waypoint],
    wanted_mm: f64,
    options: &PlateOptions<F>,
    progress: ProgressFn<'_>,
) -> Result<Isometry3<f64>, PlateError> {
    let PlateOptions { samples, stop_margin, margin_mm, comfortable_mm, rim_mm, .. } = *options;
    let middle = centred_on_plate(waypoints.iter().map(|waypoint| &waypoint.position));
    let centred = |at: &Waypoint| Waypoint { position: middle * at.position, axis: at.axis };
    let all: Vec<Waypoint> = waypoints.iter().map(centred).collect();
    let chosen = representative_waypoints(&all, options.representatives, options.lever_mm)?;
    let few: Vec<Waypoint> = chosen.waypoints.iter().map(|&index| all[index]).collect();

    let equipment = workcell.equipment();
    let widest = |of: fn(&Point3<f64>) -> f64| all.iter().map(|at| of(&at.position)).fold(0.0, f64::max) + rim_mm;
    let plate_mm = equipment.plate_diameter_mm(wanted_mm);
    let rectangle = equipment.model().plate.size_mm;
    let spare_mm = match rectangle {
        Some([x, y]) => (x / 2.0 - widest(|p| p.x.abs())).min(y / 2.0 - widest(|p| p.y.abs())),
        None => plate_mm / 2.0 - widest(|p| p.x.hypot(p.y)),
    };
    let stands = matches!(equipment.part_frame().0, Mount::Base | Mount::Ground);
    let turns = if stands && rectangle.is_none() { options.turns } else { 1 };
    let places = place_grid(spare_mm.max(0.0), options.steps, turns)?;

    let mut model = equipment.scene(plate_mm);
    (model.margin, model.allowed) = (margin_mm, nozzle_pairs(&[PLATE]));
    let scene = Scene::new(model)?;
    let postures = BestPosture::new(workcell, &scene, samples, comfortable_mm)?;
    let postures = postures.within(workcell.limits().within_margin(stop_margin));
    // The part leaves the middle for reach and clearance only, not for a little more of either.
    let assess = |at: &Waypoint| postures.assess(at).map(|found| Assessment { quality: 0.0, ..found });
    let best = best_place(&places, &few, comfortable_mm, |_, at| assess(at), progress)?;
    Ok(best.place.pose() * middle)
}
