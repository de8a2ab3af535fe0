//! A vase of one bead that winds upwards, the nozzle along its wall, as a machine file for a controller; read again and measured.
//!
//! ```sh
//! cargo run -p curvlay-toolpath --example leaning_vase_gcode -- vase.gcode
//! ```

use curvlay_toolpath::gcode::{GcodeReader, Move, ReadOptions, WriteOptions, write_gcode};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use std::error::Error;
use std::f64::consts::{PI, TAU};

/// Height of the vase, of a layer, width of the bead, diameter of the filament, mm.
const HEIGHT: f64 = 60.0;
const LAYER: f64 = 0.4;
const BEAD: f64 = 0.9;
const FILAMENT: f64 = 1.75;
const POINTS_A_TURN: usize = 120;

/// Radius of the wall and its slope at a height: it opens by up to 41 degrees.
fn wall(z: f64) -> [f64; 2] {
    let wave = TAU * z / HEIGHT;
    [18.0 + 8.0 * wave.sin(), 8.0 * TAU / HEIGHT * wave.cos()]
}

/// Tip and direction of the nozzle after some turns.
fn place(turns: f64) -> (Point3<f64>, UnitVector3<f64>) {
    let z = (LAYER * turns).max(0.2);
    let ([radius, slope], (sin, cos)) = (wall(z), (TAU * turns).sin_cos());
    (
        Point3::new(radius * cos, radius * sin, z),
        UnitVector3::new_normalize(Vector3::new(slope * cos, slope * sin, 1.0)),
    )
}

fn main() -> Result<(), Box<dyn Error>> {
    let steps = (HEIGHT / LAYER) as usize * POINTS_A_TURN;
    let (start, up) = place(0.0);
    let mut moves = vec![Move::Travel { tip: start, direction: up, feed_mm_s: 80.0 }];
    let mut laid = 0.0;
    for step in 1..=steps {
        let at = |step: usize| place(step as f64 / POINTS_A_TURN as f64);
        let ((from, _), (tip, direction)) = (at(step - 1), at(step));
        // The layers are a pitch apart along z: thinner by the cosine of the slope across the wall.
        let volume = (tip - from).norm() * BEAD * LAYER * direction.z;
        laid += volume;
        let filament_mm = volume / (PI * FILAMENT * FILAMENT / 4.0);
        moves.push(Move::Print { tip, direction, filament_mm, feed_mm_s: 30.0 });
    }
    let mut file = Vec::new();
    let written = write_gcode(moves, &WriteOptions::default(), &mut file)?;
    println!("{} moves, {} bytes", written.moves, written.bytes);

    let (mut filament, mut lean) = (0.0, 0.0f64);
    for item in GcodeReader::new(&file[..], ReadOptions::default())? {
        if let Move::Print { direction, filament_mm, .. } = item? {
            filament += filament_mm;
            lean = lean.max(direction.z.min(1.0).acos());
        }
    }
    let read = filament * PI * FILAMENT * FILAMENT / 4.0;
    println!(
        "laid {laid:.1} mm3, read again {read:.1} mm3; the nozzle leans by up to {:.1} degrees",
        lean.to_degrees()
    );
    if let Some(name) = std::env::args().nth(1) {
        std::fs::write(&name, &file)?;
        println!("{name} written");
    }
    Ok(())
}
