//! Risky area: what hangs over and lies on nothing (Eq. 2.1).

use crate::planar::solid::Wall;
use nalgebra::{Point3, Vector3};

/// What counts as risky on a part.
#[derive(Clone, Debug)]
pub(super) struct RiskModel {
    /// The cells that are printed before it.
    pub(super) earlier: Vec<u32>,
    pub(super) direction: Vector3<f64>,
    /// Height of the platform along the direction.
    pub(super) floor: f64,
    /// Minus the sine of the self-support angle.
    pub(super) limit: f64,
}

impl RiskModel {
    pub(super) fn risky(&self, walls: &[Wall]) -> f64 {
        walls
            .iter()
            .filter(|wall| self.is_risky(wall))
            .map(|wall| area_vector(&wall.places).norm())
            .fold(0.0, |sum, area| sum + area)
    }

    /// Area on earlier parts.
    pub(super) fn seam(&self, walls: &[Wall]) -> f64 {
        let is_seam = |wall: &&Wall| wall.beyond.is_some_and(|beyond| self.earlier.contains(&beyond));
        walls.iter().filter(is_seam).map(|wall| area_vector(&wall.places).norm()).fold(0.0, |sum, area| sum + area)
    }

    /// Eq. 2.1, but for what lies on earlier parts or on the platform.
    pub(super) fn is_risky(&self, wall: &Wall) -> bool {
        let vector = area_vector(&wall.places);
        vector.dot(&self.direction) < self.limit * vector.norm() && !self.is_supported(wall)
    }

    /// Whether a wall lies on an earlier part or on the platform.
    pub(super) fn is_supported(&self, wall: &Wall) -> bool {
        match wall.beyond {
            Some(beyond) => self.earlier.contains(&beyond),
            None => wall.places.iter().all(|p| p.coords.dot(&self.direction) <= self.floor),
        }
    }
}

pub(super) fn area_vector([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)) / 2.0
}
