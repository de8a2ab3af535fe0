//! A nozzle follows a circle on a dome. The turn about its own axis is free: which turns let a UR5 reach every waypoint, and how near does it
//! come to a singularity?
//!
//! ```sh
//! cargo run -p curvlay-kinematics --example tool_angles
//! ```

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_kinematics::{Arm, nozzle_frame, robots};
use std::error::Error;
use std::f64::consts::TAU;

/// Centre of the dome in the base, its radius, and how far from its top the circle lies; mm and rad.
const CENTRE: Point3<f64> = Point3::new(420.0, 120.0, 80.0);
const RADIUS: f64 = 60.0;
const FROM_TOP: f64 = 0.7;
const WAYPOINTS: u32 = 72;

/// Tip frame at a waypoint: the nozzle comes from outside, along the normal, turned by `angle` about it.
fn base_tip(waypoint: u32, angle: f64) -> Isometry3<f64> {
    let (sin, cos) = (TAU * f64::from(waypoint) / f64::from(WAYPOINTS)).sin_cos();
    let normal = Vector3::new(FROM_TOP.sin() * cos, FROM_TOP.sin() * sin, FROM_TOP.cos());
    let flow = UnitVector3::new_normalize(-normal);
    nozzle_frame(&(CENTRE + normal * RADIUS), &flow) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arm = Arm::new(&robots::UR5)?;
    // The nozzle leans against the flange by 30 degrees, so that its turn moves the wrist.
    let lean = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 30f64.to_radians());
    let flange_tip = Isometry3::from_parts(Translation3::new(40.0, 0.0, 120.0), lean);
    let tip_flange = flange_tip.inverse();
    println!("{:>8} {:>8} {:>14} {:>16}", "turn deg", "reached", "branches least", "manipulability");
    for turn in 0..8 {
        let angle = TAU * f64::from(turn) / 8.0;
        let (mut reached, mut branches, mut lowest) = (0, usize::MAX, f64::INFINITY);
        for waypoint in 0..WAYPOINTS {
            let pose = base_tip(waypoint, angle) * tip_flange;
            let found = arm.inverse(&pose)?;
            reached += u32::from(!found.is_empty());
            branches = branches.min(found.len());
            // Each solution goes back to the pose that it was found for.
            for (_, joints) in found.iter() {
                let back = arm.forward(joints);
                assert!((back.translation.vector - pose.translation.vector).norm() < 1e-6);
            }
            let best = found.iter().map(|(_, joints)| arm.manipulability(joints)).fold(0.0, f64::max);
            lowest = lowest.min(best);
        }
        println!("{:8.0} {reached:5}/{WAYPOINTS} {branches:14} {lowest:16.3e}", angle.to_degrees());
    }
    Ok(())
}
