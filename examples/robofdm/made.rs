//! What a run makes.

use super::decompose::Divided;
use curvlay_examples::motion::Printed;
use curvlay_examples::nalgebra::Vector3;

/// What a run makes.
pub struct Made {
    /// How many there are in turn.
    pub filaments: u32,
    /// Direction of the load.
    pub load: Option<Vector3<f64>>,
    /// The parts.
    pub divided: Divided,
    /// How they are printed.
    pub printed: Option<Printed>,
}

impl Made {
    /// The least angle between the load and the normal of a seam of a part, in radians.
    pub fn load_angle(&self, part: usize) -> Option<f64> {
        let load = self.load?;
        let angles = self.divided.parts.parts[part].seams.iter().filter_map(|seam| seam.load_angle(&load));
        angles.reduce(f64::min)
    }

    /// The number of the part of a layer, from 1; 0 is the pedestal.
    pub fn part_of(&self, printed: &Printed, layer: u32) -> usize {
        printed.part_of(layer as usize) + 1 - self.divided.before_parts()
    }

    /// That of all seams.
    pub fn least_load_angle(&self) -> Option<f64> {
        (0..self.divided.parts.parts.len()).filter_map(|part| self.load_angle(part)).reduce(f64::min)
    }
}
