//! The shape of the nozzle: a flat tip, a cone, a block on top of it, round about its axis.

use nalgebra::{Point3, Vector3};

/// Where the nozzle is on the part: its tip in millimetres, and the direction from the tip into the nozzle, of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NozzlePose {
    /// The tip.
    pub tip: Point3<f64>,
    /// From the tip into the nozzle.
    pub axis: Vector3<f64>,
}

/// A nozzle, in millimetres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// Radius of the tip.
    pub tip: f64,
    /// Radius of the cone where the block begins.
    pub cone: f64,
    /// Height of the cone.
    pub cone_height: f64,
    /// Radius of the block.
    pub block: f64,
    /// Height of its top over the tip.
    pub top: f64,
}

impl Nozzle {
    /// Diameter of the tip, half angle and height of the cone, diameter of the block, height of its top.
    ///
    /// # Errors
    /// What cannot be, in one line.
    pub fn new([tip, half_angle, cone_height, block, top]: [f64; 5]) -> Result<Self, String> {
        let sizes = [("tip", tip), ("height of the cone", cone_height), ("block", block), ("top", top)];
        if let Some((name, size)) = sizes.iter().find(|(_, size)| !(*size > 0.0 && *size <= 1e4)) {
            return Err(format!("the nozzle's {name} is {size} mm: it must be above 0 and at most 10000"));
        }
        if !(half_angle > 0.0 && half_angle < 89f64.to_radians()) {
            return Err(format!(
                "the nozzle's half angle is {} degrees: above 0 and below 89",
                half_angle.to_degrees()
            ));
        }
        if top <= cone_height {
            return Err(format!("the nozzle's top, {top} mm, must be above its cone, {cone_height} mm"));
        }
        let cone = 0.5 * tip + cone_height * half_angle.tan();
        Ok(Nozzle { tip: 0.5 * tip, cone, cone_height, block: (0.5 * block).max(cone), top })
    }

    /// How far a place is outside of it; negative inside.
    pub fn distance(&self, pose: &NozzlePose, place: &Point3<f64>) -> f64 {
        let way = place - pose.tip;
        let height = way.dot(&pose.axis);
        let radius = (way.norm_squared() - height * height).max(0.0).sqrt();
        self.cone_distance(radius, height).min(self.block_distance(radius, height))
    }

    /// Signed distance to the cone, in radius and height. Sizes are millimetres: squares of them neither overflow nor vanish.
    fn cone_distance(&self, radius: f64, height: f64) -> f64 {
        let (slope, rise) = (self.cone - self.tip, self.cone_height);
        let squared = slope * slope + rise * rise;
        let along = (radius - self.tip) * slope + height * rise;
        // Beyond an end of it, and out of its side.
        let (ends, side) = ((-height).max(height - rise), (radius - self.tip) * rise - height * slope);
        if ends <= 0.0 && side <= 0.0 {
            return ends.max(side / squared.sqrt());
        }
        let square = |x: f64, y: f64| x * x + y * y;
        let share = (along / squared).clamp(0.0, 1.0);
        let to_side = square(radius - self.tip - share * slope, height - share * rise);
        let to_tip = square((radius - self.tip).max(0.0), height);
        let to_top = square((radius - self.cone).max(0.0), height - rise);
        to_side.min(to_tip).min(to_top).sqrt()
    }

    /// The same of the block.
    fn block_distance(&self, radius: f64, height: f64) -> f64 {
        let (across, along) = (radius - self.block, (self.cone_height - height).max(height - self.top));
        if across <= 0.0 || along <= 0.0 {
            return across.max(along);
        }
        (across * across + along * along).sqrt()
    }

    /// The lowest point of it above the plane z = 0.
    pub fn lowest(&self, pose: &NozzlePose) -> f64 {
        let lean = (1.0 - pose.axis.z * pose.axis.z).max(0.0).sqrt();
        let edge = |radius: f64, height: f64| pose.tip.z + pose.axis.z * height - radius * lean;
        let edges = [(self.tip, 0.0), (self.block, self.cone_height), (self.block, self.top)];
        edges.map(|(radius, height)| edge(radius, height)).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// A box that contains it.
    pub fn bounds(&self, pose: &NozzlePose) -> [Point3<f64>; 2] {
        let lean = pose.axis.map(|x| (1.0 - x * x).max(0.0).sqrt());
        let around = |height: f64, radius: f64| {
            let middle = pose.tip + pose.axis * height;
            [middle - lean * radius, middle + lean * radius]
        };
        let all = [around(0.0, self.tip), around(self.cone_height, self.block), around(self.top, self.block)];
        let fold = |side: usize, pick: fn(f64, f64) -> f64| {
            Point3::from(Vector3::from_fn(|axis, _| {
                pick(pick(all[0][side][axis], all[1][side][axis]), all[2][side][axis])
            }))
        };
        [fold(0, f64::min), fold(1, f64::max)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn nozzle() -> Nozzle {
        Nozzle::new([1.0, std::f64::consts::FRAC_PI_4, 8.0, 20.0, 60.0]).unwrap()
    }

    #[test]
    fn closed_forms() {
        let (nozzle, pose) = (nozzle(), NozzlePose { tip: Point3::origin(), axis: Vector3::z() });
        let distance = |x: f64, z: f64| nozzle.distance(&pose, &Point3::new(x, 0.0, z));
        assert!((distance(0.0, -2.0) - 2.0).abs() < 1e-12 && (distance(12.0, 30.0) - 2.0).abs() < 1e-12);
        assert!((distance(1.5, 0.0) - 0.5f64.sqrt()).abs() < 1e-12 && (distance(0.0, 70.0) - 10.0).abs() < 1e-12);
        assert!(distance(0.0, 20.0) < -9.9 && distance(9.5, 7.0) > 0.9);
        assert!((nozzle.lowest(&pose)).abs() < 1e-12);
        let lying = NozzlePose { tip: Point3::new(0.0, 0.0, 4.0), axis: Vector3::x() };
        assert!((nozzle.lowest(&lying) + 6.0).abs() < 1e-12);
        assert!(Nozzle::new([1.0, 0.7, 8.0, 20.0, 7.0]).unwrap_err().contains("top"));
        assert!(Nozzle::new([f64::NAN, 0.7, 8.0, 20.0, 70.0]).unwrap_err().contains("tip is NaN"));
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(64) })]

        /// The twin takes the nearest of many points of the surface.
        #[test]
        fn outside_it_is_the_nearest_point(place in prop::array::uniform3(-30f64..70.0), lean in -1.5f64..1.5) {
            let nozzle = nozzle();
            let pose = NozzlePose { tip: Point3::new(1.0, 2.0, 3.0), axis: Vector3::new(lean.sin(), 0.0, lean.cos()) };
            let place = Point3::from(place);
            let found = nozzle.distance(&pose, &place);
            let way = place - pose.tip;
            let height = way.dot(&pose.axis);
            let radius = (way - pose.axis * height).norm();
            let outline = [[0.0, 0.0], [0.5, 0.0], [8.5, 8.0], [10.0, 8.0], [10.0, 60.0], [0.0, 60.0]];
            let mut least = f64::INFINITY;
            for ends in outline.windows(2) {
                for k in 0..=2000 {
                    let share = f64::from(k) / 2000.0;
                    let at = [0, 1].map(|c| ends[0][c] + share * (ends[1][c] - ends[0][c]));
                    least = least.min((radius - at[0]).hypot(height - at[1]));
                }
            }
            if found > 0.0 {
                prop_assert!((found - least).abs() < 0.02, "{found} {least}");
            }
            let [low, high] = nozzle.bounds(&pose);
            if found <= 0.0 {
                prop_assert!((0..3).all(|k| place[k] >= low[k] - 1e-9 && place[k] <= high[k] + 1e-9));
                prop_assert!(place.z >= nozzle.lowest(&pose) - 1e-9);
            }
        }
    }
}
