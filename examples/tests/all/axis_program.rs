//! Moves of a part, planned for the machines that come along, written in flavours, read back, and judged by the machine's own forward kinematics.

use curvlay_examples::axis_program::{axes_of, write_axis_program};
use curvlay_kinematics::machine::{AxisPlanOptions, FiveAxis};
use curvlay_toolpath::gcode::flavour::{
    AxisMove, AxisReader, Flavour, FlavourReadOptions, MachineAxis, ProgramOptions,
};
use curvlay_toolpath::gcode::{EndLift, Move};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3, distance};
use std::f64::consts::TAU;
use std::path::Path;

fn machine(name: &str) -> FiveAxis {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("machines/{name}.json"));
    FiveAxis::from_json(&std::fs::read(path).unwrap()[..]).unwrap()
}

/// Rings up a small cone whose wall leans outwards, with a retraction between two rings.
fn cone() -> Vec<Move> {
    let mut moves = Vec::new();
    for layer in 0..4 {
        let z = 30.0 + 0.3 * f64::from(layer);
        let at = |k: u32| {
            let (turn, radius) = (TAU * f64::from(k) / 48.0, 6.0 + 0.1 * f64::from(layer));
            let direction = UnitVector3::new_normalize(Vector3::new(0.3 * turn.cos(), 0.3 * turn.sin(), 1.0));
            (Point3::new(radius * turn.cos(), radius * turn.sin(), z), direction)
        };
        let (tip, direction) = at(0);
        moves.push(Move::Travel { tip: tip + direction.into_inner() * 2.0, direction, feed_mm_s: 50.0 });
        moves.push(Move::Travel { tip, direction, feed_mm_s: 50.0 });
        moves.push(Move::Prime { filament_mm: 1.0, feed_mm_s: 25.0 });
        moves.extend((1..=48).map(|k| {
            let (tip, direction) = at(k);
            Move::Print { tip, direction, filament_mm: 0.03, feed_mm_s: 15.0 }
        }));
        moves.push(Move::Retract { filament_mm: 1.0, feed_mm_s: 40.0 });
        moves.push(Move::Travel { tip: tip + direction.into_inner() * 2.0, direction, feed_mm_s: 50.0 });
    }
    moves
}

/// Tips of all beads by the forward kinematics of the machine, and the sum of filament in beads.
fn beads<const N: usize>(file: &str, machine: &FiveAxis, flavour: &Flavour) -> (Vec<Point3<f64>>, f64) {
    let axes: [MachineAxis; N] = axes_of(machine).try_into().unwrap();
    let moves = AxisReader::new(file.as_bytes(), &axes, flavour, FlavourReadOptions::default()).unwrap();
    let (mut tips, mut filament) = (Vec::new(), 0.0);
    for item in moves.map(Result::unwrap) {
        if let AxisMove::Print { axes, filament_mm, .. } = item {
            let mut all = [0.0; 5];
            all[..N].copy_from_slice(&axes);
            tips.push(machine.forward(&all).0);
            filament += filament_mm;
        }
    }
    (tips, filament)
}

/// Every waypoint of the part is a place of the program, to the digits of the file; filament is all there; times are those of the plan.
#[test]
fn programs_bring_the_tip_where_the_part_is() {
    for (name, flavour) in [
        ("bc-table-tcp", "linuxcnc-tcp"),
        ("bc-table-tcp", "siemens-axes"),
        ("bc-table-tcp", "heidenhain-axes"),
        ("head-head-gantry", "linuxcnc"),
        ("head-head-gantry", "linuxcnc-g94"),
        ("klipper-tilting-head", "klipper-axes"),
        ("open5x-table", "reprapfirmware"),
        ("polar-tilting-head", "reprapfirmware"),
    ] {
        let machine = machine(name);
        let axes = axes_of(&machine);
        let flavour = Flavour::built_in(flavour).unwrap().for_machine(&axes);
        let mut file = Vec::new();
        let options = ProgramOptions { start: Some(""), ..ProgramOptions::default() };
        let (written, summary) =
            write_axis_program(&machine, cone(), &flavour, AxisPlanOptions::default(), &options, &mut file)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
        let file = String::from_utf8(file).unwrap();
        let (tips, filament) = match axes.len() {
            4 => beads::<4>(&file, &machine, &flavour),
            _ => beads::<5>(&file, &machine, &flavour),
        };
        assert!(summary.max_tip_error_mm <= 0.02 && written.written.bytes == file.len() as u64);
        // Half a digit of each axis: 1e-5 degrees at 200 mm are 4e-5 mm.
        let off = |tip: &Point3<f64>| tips.iter().map(|other| distance(tip, other)).fold(f64::INFINITY, f64::min);
        let allowed = if name == "polar-tilting-head" { 0.02 } else { 5e-4 };
        let worst = cone().into_iter().filter_map(|item| match item {
            Move::Print { tip, .. } => Some(off(&tip)),
            _ => None,
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < allowed, "{name}, {}: {worst}", flavour.name);
        let has_axis = matches!(flavour.filament, curvlay_toolpath::gcode::flavour::FilamentWords::Axis { .. });
        assert!(!has_axis || (filament - 4.0 * 48.0 * 0.03).abs() < 1e-3, "{name}: {filament}");
    }
}

/// The nozzle leaves the part behind a last bead, and a tip out of reach is the machine's error.
#[test]
fn ends_and_errors() {
    let machine = machine("bc-table-tcp");
    let flavour = Flavour::built_in("linuxcnc-tcp").unwrap();
    let mut moves: Vec<Move> = cone();
    moves.truncate(20);
    let written = |moves: Vec<Move>| {
        let mut file = Vec::new();
        let end = Some(EndLift { lift_mm: 12.0, ..EndLift::default() });
        let options = ProgramOptions { end, ..ProgramOptions::default() };
        write_axis_program(&machine, moves, &flavour, AxisPlanOptions::default(), &options, &mut file)
            .map(|_| String::from_utf8(file).unwrap())
            .map_err(|error| error.to_string())
    };
    let file = written(moves.clone()).unwrap();
    let Move::Print { tip, direction, .. } = moves[19] else { panic!("no bead") };
    let up = tip + direction.into_inner() * 12.0;
    let lifted = file.lines().rfind(|line| line.starts_with("G0 ")).unwrap();
    assert!(lifted.starts_with(&format!("G0 X{:.4}", up.x).trim_end_matches('0').to_owned()), "{lifted} {up}");
    let direction = Vector3::z_axis();
    let far = vec![Move::Travel { tip: Point3::new(0.0, 900.0, 10.0), direction, feed_mm_s: 50.0 }];
    assert!(written(far).unwrap_err().starts_with("move 0, tip at 0.00 900.00 10.00: "));
    assert_eq!(written(vec![]), Err("there is no move to write".into()));
}
