//! Where the part stands on its plate: in the middle, unless waypoints are out of reach there, or tight.

use super::Print;
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::in_the_middle;
use curvlay_kinematics::scene::{Mount, Scene};
use curvlay_kinematics::workcell::{PLATE, Workcell, nozzle_pairs};
use curvlay_kinematics::{
    Assessment, BestPosture, JointLimits, Waypoint, best_place, place_grid, representative_waypoints,
};
use curvlay_trajectory::print::PrintOptions;
use nalgebra::Isometry3;
use std::ops::ControlFlow;

/// Waypoints that stand for the whole print, and how many millimetres a radian between directions counts among them: about
/// what the wrist of an arm has to move.
const WAYPOINTS: usize = 120;
const LEVER_MM: f64 = 150.0;

/// Places from the middle of the plate to as far out as the part stays on it; and turns of it, where neither joint 6 nor a
/// table turns it.
const STEPS: u32 = 3;
const TURNS: u32 = 8;

impl Print<'_> {
    /// Maps the part to the frame of what carries it. Its middle, the mean of all waypoints, comes to the middle of the plate,
    /// or so near to it that the fewest waypoints are without a posture, and the fewest with little clearance: with the arm
    /// against itself, the plate, and whatever stands there. The part itself is not looked at.
    pub fn place<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        cell: &W,
        options: &PrintOptions<N, F>,
        bars: &Bars,
    ) -> Result<Isometry3<f64>, Failure> {
        let paths = &self.machine.resolved.paths;
        let middle = in_the_middle(paths);
        let all: Vec<Waypoint> = paths
            .iter()
            .flat_map(|path| &path.waypoints)
            .map(|waypoint| Waypoint { position: middle * waypoint.tip, axis: waypoint.direction })
            .collect();
        let chosen = representative_waypoints(&all, WAYPOINTS, LEVER_MM).map_err(failure)?;
        let few: Vec<Waypoint> = chosen.waypoints.iter().map(|&index| all[index]).collect();

        let equipment = cell.equipment();
        let wide = all.iter().map(|at| at.position.x.hypot(at.position.y)).fold(0.0, f64::max) + self.paths.bead_mm;
        let plate = equipment.plate_diameter_mm(self.field.platform_diameter_mm());
        let turns = if equipment.part_frame().0 == Mount::Base { TURNS } else { 1 };
        let places = place_grid((plate / 2.0 - wide).max(0.0), STEPS, turns).map_err(failure)?;

        let mut model = equipment.scene(plate);
        (model.margin, model.allowed) = (self.args.margin, nozzle_pairs(&[PLATE]));
        let scene = Scene::new(model).map_err(failure)?;
        let [comfortable, ..] = self.growing_options().clearances_mm;
        let JointLimits { lower, upper, .. } = *cell.limits();
        let (lower, upper) =
            (lower.map(|stop| stop + options.stop_margin), upper.map(|stop| stop - options.stop_margin));
        let postures = BestPosture::new(cell, &scene, options.samples, comfortable).map_err(failure)?;
        let postures = postures.within(JointLimits { lower, upper, ..*cell.limits() });
        // The part leaves the middle for reach and clearance only, not for a little more of either.
        let assess = |at: &Waypoint| postures.assess(at).map(|found| Assessment { quality: 0.0, ..found });
        let progress = |p: curvlay_kinematics::Progress| {
            bars.update(p.stage, p.done, p.total);
            ControlFlow::Continue(())
        };
        let best = best_place(&places, &few, comfortable, |_, at| assess(at), &progress).map_err(failure)?;
        Ok(best.place.pose() * middle)
    }
}
