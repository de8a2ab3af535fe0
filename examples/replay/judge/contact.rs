//! Nozzle against what is built so far, and against the plate, as time goes on.

use super::super::axes::NozzlePose;
use super::super::controller::Tick;
use super::worst::Worst;
use curvlay_examples::laid::{Nozzle, NozzleInBeads};

/// The nozzle in something.
#[derive(Clone, Debug, Default)]
pub struct Touch {
    /// The deepest, in millimetres.
    pub worst: Worst,
    /// How many times it began.
    pub times: u64,
    /// Seconds for which it lasts.
    pub seconds: f64,
    is_on: bool,
}

/// The judge.
#[derive(Clone, Debug)]
pub struct Contact {
    beads: NozzleInBeads,
    plate_radius: f64,
    tick_s: f64,
    /// With beads.
    pub built: Touch,
    /// With the plate.
    pub plate: Touch,
}

impl Contact {
    /// Nothing is built.
    pub fn new(nozzle: Nozzle, plate_mm: Option<f64>, tick_s: f64, allowed: f64) -> Self {
        Contact {
            beads: NozzleInBeads::new(nozzle, allowed),
            plate_radius: 0.5 * plate_mm.unwrap_or(f64::INFINITY),
            tick_s,
            built: Touch::default(),
            plate: Touch::default(),
        }
    }

    /// How many capsules are laid.
    pub fn beads(&self) -> usize {
        self.beads.len()
    }

    /// A tick; `height_mm` is that of the bead that is laid, if the tip lays one.
    pub fn take(&mut self, tick: &Tick, pose: &NozzlePose, height_mm: Option<f64>) {
        let depth = self.beads.depth(pose);
        self.built.take(depth, tick, pose, self.tick_s);
        let is_over_plate = pose.tip.x.hypot(pose.tip.y) <= self.plate_radius;
        let sunk = if is_over_plate { self.beads.below_plate(pose) } else { 0.0 };
        self.plate.take(sunk, tick, pose, self.tick_s);
        self.beads.lay(pose, height_mm);
    }
}

impl Touch {
    fn take(&mut self, depth: f64, tick: &Tick, pose: &NozzlePose, tick_s: f64) {
        let is_on = depth > 1e-9;
        self.times += u64::from(is_on && !self.is_on);
        self.seconds += if is_on { tick_s } else { 0.0 };
        self.is_on = is_on;
        if is_on {
            self.worst.take(depth, tick, Some(&pose.tip));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    fn tick() -> Tick {
        Tick {
            seconds: 0.0,
            axes: [0.0; 8],
            filament_mm: 0.0,
            extrudes: true,
            place: Default::default(),
            blend_mm: 0.0,
            streams: true,
            jumped: false,
        }
    }

    fn nozzle() -> Nozzle {
        Nozzle::new([1.0, std::f64::consts::FRAC_PI_4, 8.0, 20.0, 60.0]).unwrap()
    }

    fn upright(x: f64, y: f64, z: f64) -> NozzlePose {
        NozzlePose { tip: Point3::new(x, y, z), axis: Vector3::z() }
    }

    #[test]
    fn a_wall_is_hit_by_a_nozzle_that_comes_back_lower() {
        let mut contact = Contact::new(nozzle(), None, 0.01, 0.0);
        for k in 0..200 {
            contact.take(&tick(), &upright(f64::from(k) * 0.1, 0.0, 5.0), Some(0.5));
        }
        assert_eq!((contact.built.times, contact.beads() >= 9), (0, true));
        // Beside it, lower: the cone, 4 mm above the tip, is 4.5 mm wide.
        for k in 0..200 {
            contact.take(&tick(), &upright(f64::from(k) * 0.1, 2.0, 1.0), None);
        }
        assert_eq!(contact.built.times, 1);
        let slanted = (2.0 - 0.5 - 3.75) / 2f64.sqrt();
        assert!((contact.built.worst.value - (0.25 - slanted)).abs() < 0.05, "{}", contact.built.worst.value);
        assert!(contact.plate.times == 0);
        contact.take(&tick(), &upright(50.0, 50.0, -0.5), None);
        assert!((contact.plate.worst.value - 0.5).abs() < 1e-12);
    }
}
