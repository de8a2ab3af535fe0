//! Programs for LinuxCNC, read by its own interpreter.

use crate::flavour_common::*;
use crate::gcode_common::unit;
use curvlay_toolpath::gcode::flavour::*;
use curvlay_toolpath::gcode::{Move, RotaryTable};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3, distance};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A bead on a part: tips and directions.
type Bead = Vec<(Point3<f64>, UnitVector3<f64>)>;

/// Walls of a part that turns about z: for each layer a ring of the radius and lean at its height, with waves.
fn rings(layers: u32, radius: impl Fn(f64) -> f64, lean: impl Fn(f64) -> f64, waves: f64) -> Vec<Bead> {
    let ring = |layer: u32| {
        let height = 0.3 * f64::from(layer + 1);
        let point = |k: u32| {
            let turn = TAU * f64::from(k) / 90.0;
            let (r, z) = (radius(height) + 0.3 * (waves * turn).sin(), height + 0.2 * (3.0 * turn).cos());
            let lean = lean(height);
            let direction = unit(lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos());
            (Point3::new(r * turn.cos(), r * turn.sin(), z), direction)
        };
        (0..=90).map(point).collect()
    };
    (0..layers).map(ring).collect()
}

/// A dome, a wavy vase that leans outwards, a tube that leans inwards.
fn parts() -> [(&'static str, Vec<Bead>); 3] {
    [
        ("dome", rings(40, |z| (20f64.powi(2) - z * z).sqrt(), |z| (z / 20.0).asin(), 0.0)),
        ("vase", rings(30, |z| 12.0 + 0.4 * z, |z| 0.05 * z, 8.0)),
        ("tube", rings(25, |z| 15.0 - 0.2 * z, |_| -0.4, 5.0)),
    ]
}

/// The beads on a table that tilts and turns, by the axes of [`RotaryTable`], with a retraction between two beads.
fn on_table(beads: &[Bead], table: &RotaryTable) -> Vec<AxisMove<5>> {
    let (mut all, mut near) = (Vec::new(), [0.0; 2]);
    let axes_at = |tip: &Point3<f64>, direction: &UnitVector3<f64>, near: &mut [f64; 2]| {
        *near = table.angles(direction, *near).unwrap();
        let at = table.machine_point(tip, *near);
        [at.x, at.y, at.z, near[0], near[1]]
    };
    for bead in beads {
        let (tip, direction) = bead[0];
        all.push(AxisMove::Travel { axes: axes_at(&tip, &direction, &mut near), seconds: 0.5 });
        all.push(AxisMove::Still(Move::Prime { filament_mm: 1.0, feed_mm_s: 30.0 }));
        for pair in bead.windows(2) {
            let way = distance(&pair[0].0, &pair[1].0);
            let axes = axes_at(&pair[1].0, &pair[1].1, &mut near);
            all.push(AxisMove::Print { axes, seconds: (way / 20.0).max(0.01), filament_mm: 0.07 * way });
        }
        all.push(AxisMove::Still(Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 }));
    }
    all
}

/// An empty folder with a configuration in which `M428` and `M429` exist, as in the samples of LinuxCNC.
fn configuration() -> (PathBuf, PathBuf) {
    let folder = std::env::temp_dir().join(format!("curvlay-rs274-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut text = format!("[RS274NGC]\nSUBROUTINE_PATH = {}\n", folder.display());
    for (code, kinematics) in [(428, 1), (429, 0)] {
        let sub = format!("o<{code}remap>sub\nM68 E3 Q{kinematics}\nM66 E0 L0\no<{code}remap>endsub\nM2\n");
        std::fs::write(folder.join(format!("{code}remap.ngc")), sub).unwrap();
        text += &format!("REMAP = M{code} modalgroup=10 ngc={code}remap\n");
    }
    let ini = folder.join("machine.ini");
    std::fs::write(&ini, text).unwrap();
    (folder, ini)
}

/// What the interpreter makes of a program: X, Y, Z, A, B, C and the feed rate of each motion. Fails at the first line that it refuses.
fn interpreted(ini: &Path, program: &Path) -> Vec<([f64; 6], f64, bool)> {
    let output = Command::new("rs274").arg("-g").arg("-i").arg(ini).arg(program).output();
    let output = output.unwrap_or_else(|error| panic!("rs274: {error}; it is in Debian's linuxcnc-uspace"));
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("PROGRAM_END()"), "{}: {err}", program.display());
    let (mut all, mut rate) = (Vec::new(), 0.0);
    let numbers = |line: &str| -> Vec<f64> {
        let inside = line.split_once('(').unwrap().1.trim_end_matches(')');
        inside.split(',').map(|number| number.trim().parse().unwrap()).collect()
    };
    for line in out.lines() {
        let command = line.split_whitespace().nth(2).unwrap_or("");
        if command.starts_with("SET_FEED_RATE") {
            rate = numbers(line)[0];
        }
        let is_feed = command.starts_with("STRAIGHT_FEED");
        if is_feed || command.starts_with("STRAIGHT_TRAVERSE") {
            all.push((numbers(line).try_into().unwrap(), rate, is_feed));
        }
    }
    all
}

/// Every line is accepted, the axes arrive where they should, and LinuxCNC itself reckons the same time.
#[test]
#[ignore = "needs rs274 of linuxcnc-uspace"]
fn linuxcnc_reads_every_line() {
    let (folder, ini) = configuration();
    let mut with_a = RotaryTable { tolerance_mm: None, ..RotaryTable::default() };
    (with_a.tilt.letter, with_a.tilt.axis) = ('A', Vector3::x_axis());
    let tables = [('B', RotaryTable { tolerance_mm: None, ..RotaryTable::default() }), ('A', with_a)];
    for (part, beads) in parts() {
        for (tilt, table) in tables {
            let machine = [X, Y, Z, MachineAxis::rotary(tilt), MachineAxis::rotary('C')];
            let moves = on_table(&beads, &table);
            for mut flavour in flavours(true).into_iter().filter(|flavour| flavour.name.starts_with("linuxcnc")) {
                // The interpreter alone has X Y Z A B C.
                if let (FilamentWords::Axis { word, zero, .. }, 'A') = (&mut flavour.filament, tilt) {
                    (*word, *zero) = ("B".into(), "G92 B0".into());
                }
                let (file, result) = written_axes(&machine, &moves, &flavour, &options()).unwrap();
                let path = folder.join(format!("{part}-{tilt}-{}.ngc", flavour.name));
                std::fs::write(&path, &file).unwrap();
                let seen = interpreted(&ini, &path);
                compare(&moves, &seen, tilt);
                println!("{part}, table {tilt}C, {}: {} lines accepted", flavour.name, result.written.lines);
            }
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

fn compare(moves: &[AxisMove<5>], seen: &[([f64; 6], f64, bool)], tilt: char) {
    let order = if tilt == 'A' { [0, 1, 2, 3, 5] } else { [0, 1, 2, 4, 5] };
    // Motions of the extruder alone leave the others where they are.
    let of_axes = |at: &[f64; 6]| order.map(|k| at[k]);
    let mut seen = seen.iter().peekable();
    let mut last = [f64::NAN; 5];
    for item in moves {
        let (axes, seconds) = match *item {
            AxisMove::Travel { axes, .. } => (axes, None),
            AxisMove::Print { axes, seconds, .. } => (axes, Some(seconds)),
            _ => continue,
        };
        while seen
            .peek()
            .is_some_and(|next| of_axes(&next.0).iter().zip(last).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-9))
        {
            seen.next();
        }
        let (at, rate, is_feed) = seen.next().expect("a motion for each move");
        let at = of_axes(at);
        for k in 0..5 {
            let expected = if k < 3 { axes[k] } else { axes[k].to_degrees() };
            // The interpreter shows four digits.
            assert!((at[k] - expected).abs() < 1.1e-4, "{at:?} {axes:?}");
        }
        assert_eq!(*is_feed, seconds.is_some());
        let way = at[..3].iter().zip(last).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        if let Some(seconds) = seconds.filter(|_| way > 0.05) {
            let by_linuxcnc = 60.0 * way / rate;
            assert!((by_linuxcnc / seconds - 1.0).abs() < 4e-4 / way + 2e-3, "{by_linuxcnc} {seconds} {way}");
        }
        last = at;
    }
}
