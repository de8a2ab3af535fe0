//! A planned bead: a straight step of a tool path.

use nalgebra::{Point3, Vector3};

/// A straight step that lays material, on the part as the machine has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bead {
    /// Where it begins.
    pub from: Point3<f64>,
    /// Where it ends.
    pub to: Point3<f64>,
    /// From the tip into the nozzle, at its begin and its end, where the plan says it.
    pub directions: Option<[Vector3<f64>; 2]>,
    /// Width, in millimetres.
    pub width: f64,
    /// Height, in millimetres.
    pub height: f64,
    /// Filament for it, in millimetres.
    pub filament_mm: f64,
    /// Its path, from 0: beads of a path follow each other without a way between them.
    pub path: u32,
    /// Its layer, from 0.
    pub layer: u32,
}

impl Bead {
    /// Its length.
    pub fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The angle between a nozzle and the planned direction after a share of its length, in radians; 0 where none is planned.
    pub fn tilt_off(&self, share: f64, axis: &Vector3<f64>) -> f64 {
        self.directions.map_or(0.0, |[from, to]| {
            let planned = from + (to - from) * share;
            planned.cross(axis).norm().atan2(planned.dot(axis))
        })
    }

    /// The nearest point of it to a place, from a share of its length on: the share and the distance.
    pub fn nearest(&self, place: &Point3<f64>, first: f64) -> (f64, f64) {
        let way = self.to - self.from;
        let squared = way.norm_squared();
        let share = if squared > 0.0 { (place - self.from).dot(&way) / squared } else { 1.0 };
        let share = share.clamp(first.min(1.0), 1.0);
        (share, (self.from + way * share - place).norm())
    }
}
