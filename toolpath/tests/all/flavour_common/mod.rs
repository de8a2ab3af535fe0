//! A machine, small prints in moves of the part and of axes, and programs in memory.

use crate::gcode_common::{print, travel, unit};
use curvlay_toolpath::gcode::flavour::*;
use curvlay_toolpath::gcode::{Mark, Move, WriteError};
use curvlay_toolpath::nalgebra::Vector3;
use curvlay_toolpath::path::BeadKind;

pub const X: MachineAxis = MachineAxis::linear('X');
pub const Y: MachineAxis = MachineAxis::linear('Y');
pub const Z: MachineAxis = MachineAxis::linear('Z');

/// A table that tilts about y and turns about z.
pub const TABLE: [MachineAxis; 5] = [X, Y, Z, MachineAxis::rotary('B'), MachineAxis::rotary('C')];

pub fn flavour(name: &str) -> Flavour {
    Flavour::built_in(name).unwrap_or_else(|| panic!("no flavour {name}"))
}

/// All flavours that take moves of axes, or all others.
pub fn flavours(of_axes: bool) -> Vec<Flavour> {
    let all = Flavour::names().iter().map(|name| flavour(name));
    all.filter(|flavour| (flavour.direction == Direction::Axes) == of_axes).collect()
}

pub fn written_axes<const N: usize>(
    machine: &[MachineAxis; N],
    moves: &[AxisMove<N>],
    flavour: &Flavour,
    options: &ProgramOptions<'_>,
) -> Result<(String, FlavourWritten), WriteError> {
    let mut file = Vec::new();
    let result = write_axis_moves(machine, moves.iter().copied(), flavour, options, &mut file)?;
    Ok((checked(file, &result, moves.len(), flavour), result))
}

pub fn written_part(
    moves: &[Move],
    flavour: &Flavour,
    options: &ProgramOptions<'_>,
) -> Result<(String, FlavourWritten), WriteError> {
    let mut file = Vec::new();
    let result = write_flavour(moves.iter().copied(), flavour, options, &mut file)?;
    Ok((checked(file, &result, moves.len(), flavour), result))
}

/// What holds for every program: sums, ends of lines, lengths.
fn checked(file: Vec<u8>, result: &FlavourWritten, moves: usize, flavour: &Flavour) -> String {
    assert_eq!((result.written.bytes, result.written.moves), (file.len() as u64, moves as u64));
    let file = String::from_utf8(file).unwrap();
    assert!(file.is_ascii());
    let end = if flavour.lines.crlf { "\r\n" } else { "\n" };
    assert_eq!(file.matches('\n').count(), file.matches(end).count());
    assert_eq!(result.written.lines as usize, file.split_terminator(end).count());
    assert!(file.split_terminator(end).all(|line| line.len() <= flavour.lines.max_length), "{file}");
    file
}

pub fn options() -> ProgramOptions<'static> {
    ProgramOptions {
        name: "dome",
        nozzle_celsius: Some(210.0),
        bed_celsius: Some(62.5),
        fan: Some(0.5),
        ..ProgramOptions::default()
    }
}

/// Heat, a bead up the side of a dome, a turn while the tip stands, a retraction, a travel, a bead.
pub fn dome() -> Vec<Move> {
    let up = Vector3::z_axis();
    vec![
        Move::Mark(Mark::Layer { number: 0, z_mm: 0.3, height_mm: 0.3 }),
        travel([10.0, 0.0, 0.3], up, 50.0),
        Move::Mark(Mark::Bead { kind: BeadKind::Wall, width_mm: 0.5, height_mm: 0.3 }),
        print([9.9, 3.0, 0.45], unit(0.3, 0.0, 0.954), 0.11073, 20.0),
        print([6.338, 8.39, 0.5], unit(-0.094, 0.127, 0.987), 0.32167, 20.0),
        print([6.338, 8.39, 0.5], unit(0.0, -0.6, 0.8), 0.0004, 20.0),
        Move::Retract { filament_mm: 1.2, feed_mm_s: 40.0 },
        travel([-12.5, 0.0, 8.0], up, 80.0),
        Move::Fan { share: 1.0 },
        Move::Dwell { seconds: 0.25 },
        Move::Prime { filament_mm: 1.2, feed_mm_s: 25.0 },
        Move::Mark(Mark::Layer { number: 1, z_mm: 0.6, height_mm: 0.3 }),
        print([-13.0, 1.0 / 3.0, 8.0], unit(-0.6, 0.0, 0.8), 0.02, 15.0),
    ]
}

/// The same in axes of the [`TABLE`], by hand: a bead along the table, one with a turn, a turn at standing slides, a retraction, a travel.
pub fn dome_axes() -> Vec<AxisMove<5>> {
    let still = AxisMove::Still;
    let turned = |degrees: f64| degrees.to_radians();
    vec![
        still(Move::Mark(Mark::Layer { number: 0, z_mm: 0.3, height_mm: 0.3 })),
        AxisMove::Travel { axes: [10.0, 0.0, 0.3, 0.0, 0.0], seconds: 0.5 },
        still(Move::Mark(Mark::Bead { kind: BeadKind::Wall, width_mm: 0.5, height_mm: 0.3 })),
        AxisMove::Print { axes: [10.0, 4.0, 0.3, 0.0, 0.0], seconds: 0.2, filament_mm: 0.13 },
        AxisMove::Print { axes: [8.5103, 7.0, 5.2598, turned(-30.0), turned(45.5)], seconds: 0.5, filament_mm: 0.4 },
        AxisMove::Print { axes: [8.5103, 7.0, 5.2598, turned(-30.0), turned(60.0)], seconds: 0.1, filament_mm: 0.002 },
        still(Move::Retract { filament_mm: 1.2, feed_mm_s: 40.0 }),
        AxisMove::Travel { axes: [-12.5, 0.0, 8.0, 0.0, turned(-370.0)], seconds: 1.25 },
        still(Move::Fan { share: 1.0 }),
        still(Move::Dwell { seconds: 0.25 }),
        still(Move::Prime { filament_mm: 1.2, feed_mm_s: 25.0 }),
        still(Move::Mark(Mark::Layer { number: 1, z_mm: 0.6, height_mm: 0.3 })),
        AxisMove::Print { axes: [-13.0, 1.0 / 3.0, 8.0, 0.1, -6.5], seconds: 0.075, filament_mm: 0.02 },
        still(Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 }),
        AxisMove::Travel { axes: [-13.0, 1.0 / 3.0, 28.0, 0.1, -6.5], seconds: 0.25 },
    ]
}
