//! The postures as a pendant shows them.

use crate::postures::Posture;
use curvlay_examples::motion::turning_joints;
use curvlay_kinematics::nalgebra::Isometry3;
use curvlay_kinematics::robots::Maker;
use curvlay_kinematics::workcell::{AnyWorkcell, Equipment, Held, tool_frame};

/// Prints the arm, its tool and the postures.
pub fn print(cell: &AnyWorkcell, postures: &[Posture]) {
    let equipment = cell.equipment();
    let arm = equipment.catalogue_arm();
    println!("{}", equipment.name());
    let maker = arm.map_or_else(|| like(equipment), |arm| arm.maker);
    match arm {
        Some(arm) => {
            println!("arm: {} {}; numbers: {}", arm.maker.name(), arm.title, arm.source);
            arm.note.iter().for_each(|note| println!("note: {note}"));
        }
        None => println!("arm: given by lengths; rotations as {} shows them", maker.name()),
    }
    println!("base: {}", base(maker));
    println!("flange: {}", flange(maker));
    if equipment.arm().is_coupled() {
        println!("joint 3: counted from the horizontal, whatever joint 2 is");
    }
    if !equipment.arm().is_closed_form() || equipment.model().arm.calibration.is_some() {
        println!(
            "calibrated: positions are of the arm as built; a controller that does not know it shows the nominal ones"
        );
    }
    match equipment.model().held {
        Held::Nozzle => {
            println!("tool frame (nozzle, on the flange): {}", shown(&tool_frame(&equipment.nozzle_frame().1), maker))
        }
        Held::Part => {
            println!("tool frame (part, on the flange): {}", shown(&equipment.part_frame().1, maker));
            println!("nozzle, in the base: {}", shown(&tool_frame(&equipment.nozzle_frame().1), maker));
        }
    }
    postures.iter().for_each(|posture| of(posture, maker, equipment));
}

fn of(posture: &Posture, maker: Maker, equipment: &Equipment) {
    println!("\n{}", posture.title);
    let Some(joints) = &posture.joints else { return };
    let names: Vec<String> = joints[..turning_joints(equipment, joints.len())]
        .iter()
        .enumerate()
        .map(|(k, angle)| format!("{} {}", joint(maker, k), fixed(angle.to_degrees(), 3)))
        .collect();
    println!("  joints, deg: {}", names.join("  "));
    if let Some((track, place)) = equipment.track().zip(joints.last()) {
        println!("  track, mm: {}", fixed(track.mm(*place), 3));
    }
    println!("  flange in base: {}", shown(&posture.flange, maker));
    println!("  tool in base:   {}", shown(&posture.tool, maker));
    posture.on_part.iter().for_each(|frame| println!("  nozzle on part: {}", shown(frame, maker)));
    posture.remarks.iter().for_each(|remark| println!("  {remark}"));
}

/// The maker whose notation an arm without a name gets.
fn like(equipment: &Equipment) -> Maker {
    if equipment.arm().is_ur() { Maker::UniversalRobots } else { Maker::Abb }
}

fn joint(maker: Maker, k: usize) -> String {
    match (maker, k) {
        (_, 6) => "tilt".into(),
        (_, 7) => "turn".into(),
        (Maker::Kuka, _) => format!("A{}", k + 1),
        (Maker::Yaskawa, _) => ["S", "L", "U", "R", "B", "T"][k].into(),
        _ => format!("J{}", k + 1),
    }
}

fn base(maker: Maker) -> &'static str {
    match maker {
        Maker::UniversalRobots => {
            "the controller's base frame; ROS base_link is this one turned by 180 degrees about z"
        }
        Maker::Abb => "the base frame at the foot (wobj0 with no base offset)",
        Maker::Kuka => "$ROBROOT, at the foot ($WORLD where nobody moved it)",
        Maker::Fanuc => "the world frame: on axis 1, at the height of axis 2",
        Maker::Yaskawa => "the robot frame: on axis 1, at the height of axis 2",
        Maker::Staubli => "the world frame: on axis 1, at the height of axis 2",
        _ => "the base frame of the file",
    }
}

fn flange(maker: Maker) -> &'static str {
    match maker {
        Maker::UniversalRobots => "z along axis 6, y as the maker's table has it (TCP 0 0 0 0 0 0)",
        Maker::Abb => "tool0, z along axis 6, x down where all joints are 0",
        Maker::Kuka => "$FLANGE, z along axis 6, x down where all axes are 0",
        Maker::Fanuc | Maker::Yaskawa => "tool 0, z along axis 6, x up where all joints are 0",
        Maker::Staubli => "flange, z along axis 6, parallel to the base where all joints are 0",
        _ => "z along axis 6",
    }
}

/// A number without a minus before zero.
fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.trim_start_matches('-').chars().all(|digit| digit == '0' || digit == '.');
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// Position in millimetres and rotation.
fn shown(frame: &Isometry3<f64>, maker: Maker) -> String {
    let position: [f64; 3] = frame.translation.vector.into();
    let rotation = maker.shown(&frame.rotation);
    let numbers = |names: &[&str], values: &[f64], digits: usize| {
        let pairs = names.iter().zip(values).map(|(name, value)| format!("{name} {}", fixed(*value, digits)));
        pairs.collect::<Vec<_>>().join(" ")
    };
    let digits = if rotation.unit == "deg" { 3 } else { 5 };
    let unit = if rotation.unit.is_empty() { String::new() } else { format!(" {}", rotation.unit) };
    format!(
        "{} mm, {}{unit}",
        numbers(&["X", "Y", "Z"], &position, 2),
        numbers(rotation.names, &rotation.values, digits)
    )
}
