//! Five-axis printers: linear axes, and two rotary ones in the table, in the head, or one in each.
//!
//! At the zero posture (linear axes at 0, rotary ones at their zeros) a place `p` of the part is at `p + o` in the machine. Table axes then carry it, the one
//! that is nearer to the part first: `T_2(T_1(p + o))`. The tip is at `H(t) + L x`: head axes turn it, the one that carries the nozzle first, and linear axes move
//! all of the head. Where both meet, the nozzle is on the part.

use super::super::axes::{Axes, Limits, MAX_AXES, NozzlePose};
use super::rotary_axis::{RotaryAxis, back};
use curvlay_kinematics::machine::{self, AxisMount, MachineFileError, MachineModel};
use nalgebra::{Matrix3, Point3, Vector3};

/// Such a printer: linear axes first, in millimetres, then two rotary ones, in radians, in the order of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct FiveAxis {
    /// What a report calls it.
    pub name: String,
    /// The letters of its axes.
    pub letters: Vec<char>,
    /// Whether `X Y Z` of programs are the tip on the part, and the controller moves the axes under it.
    pub knows_tip: bool,
    /// How many of its axes are linear.
    pub linear: usize,
    rotary: [RotaryAxis; 2],
    /// Directions of linear axes; zero for one that is not there.
    directions: Matrix3<f64>,
    /// From a way of the nozzle to linear axes.
    values: Matrix3<f64>,
    /// Tip, direction of the nozzle, origin of the part, in the machine at the zero posture.
    tip: Vector3<f64>,
    nozzle: Vector3<f64>,
    origin: Vector3<f64>,
    /// Its limits.
    pub limits: Limits,
}

/// The machine of a program for which none is named.
const TABLE: &str = include_str!("table.json");

impl FiveAxis {
    /// The machine of a program for which none is named: B about y carries C about z, both through the origin of the part.
    ///
    /// # Errors
    /// Never, as long as its file is one.
    pub fn table() -> Result<Self, MachineFileError> {
        FiveAxis::from_json(TABLE.as_bytes())
    }

    /// Reads the file of a machine, as `docs/formats/machines.md` describes it.
    ///
    /// # Errors
    /// The field, or line and column.
    pub fn from_json(text: &[u8]) -> Result<Self, MachineFileError> {
        // The library reads and checks the numbers; what they mean is computed here.
        Ok(FiveAxis::new(machine::FiveAxis::from_json(text)?.model()))
    }

    /// The machine of checked numbers.
    pub fn new(model: &MachineModel) -> Self {
        let rotary = [0, 1].map(|k| {
            let axis = &model.rotary[k];
            RotaryAxis {
                axis: Vector3::from(axis.axis).normalize(),
                centre: axis.point_mm.unwrap_or_default().into(),
                zero: axis.zero_deg.to_radians(),
                is_table: axis.mount == AxisMount::Table,
            }
        });
        let mut directions = Matrix3::zeros();
        for (k, axis) in model.linear.iter().enumerate().take(3) {
            directions.set_column(k, &Vector3::from(axis.direction).normalize());
        }
        // On a head the tip is measured from the pivot of the axis that carries the nozzle.
        let pivot = if rotary[1].is_table { Vector3::zeros() } else { rotary[1].centre };
        let letters = model.linear.iter().map(|axis| axis.letter).chain(model.rotary.iter().map(|axis| axis.letter));
        FiveAxis {
            name: model.name.clone(),
            letters: letters.collect(),
            knows_tip: model.tcp,
            linear: model.linear.len(),
            rotary,
            directions,
            values: directions.pseudo_inverse(1e-9).unwrap_or_else(|_| Matrix3::zeros()),
            tip: pivot + Vector3::from(model.nozzle.tip_mm.unwrap_or_default()),
            nozzle: Vector3::from(model.nozzle.direction).normalize(),
            origin: model.part_origin_mm.into(),
            limits: limits(model),
        }
    }

    /// Sines and cosines of the rotary axes.
    fn turned(&self, axes: &Axes) -> [[f64; 2]; 2] {
        [0, 1].map(|k| self.rotary[k].turned(axes[self.linear + k]))
    }

    /// The tip in the machine with linear axes at 0, and the direction of the nozzle.
    fn head(&self, turned: &[[f64; 2]; 2]) -> [Vector3<f64>; 2] {
        let mut nozzle = [self.tip, self.nozzle];
        for k in [1, 0] {
            let axis = &self.rotary[k];
            if !axis.is_table {
                nozzle = [axis.place(turned[k], &nozzle[0]), axis.direction(turned[k], &nozzle[1])];
            }
        }
        nozzle
    }

    /// Where the nozzle is on the part at positions of the axes.
    pub fn nozzle_on_part(&self, axes: &Axes) -> NozzlePose {
        let turned = self.turned(axes);
        let [mut tip, mut axis] = self.head(&turned);
        for (direction, value) in self.directions.column_iter().zip(&axes[..self.linear]) {
            tip += direction * *value;
        }
        for k in [1, 0] {
            let table = &self.rotary[k];
            if table.is_table {
                (tip, axis) = (table.place(back(turned[k]), &tip), table.direction(back(turned[k]), &axis));
            }
        }
        NozzlePose { tip: Point3::from(tip - self.origin), axis }
    }

    /// Positions of the axes for the tip on the part and readings of the rotary axes, as a program under control of the tip has them: what is to be on a linear
    /// axis that is not there is left out.
    pub fn under_tip(&self, program: &Axes) -> Axes {
        let turned = {
            let rotary = [program[3], program[4]];
            [0, 1].map(|k| self.rotary[k].turned(rotary[k]))
        };
        let mut place = self.origin + Vector3::new(program[0], program[1], program[2]);
        for k in [0, 1] {
            if self.rotary[k].is_table {
                place = self.rotary[k].place(turned[k], &place);
            }
        }
        let linear = self.values * (place - self.head(&turned)[0]);
        let mut axes = [0.0; MAX_AXES];
        axes[..self.linear].copy_from_slice(&linear.as_slice()[..self.linear]);
        (axes[self.linear], axes[self.linear + 1]) = (program[3], program[4]);
        axes
    }

    /// The other way round: the tip, and the readings.
    pub fn of_tip(&self, axes: &Axes) -> Axes {
        let tip = self.nozzle_on_part(axes).tip;
        [tip.x, tip.y, tip.z, axes[self.linear], axes[self.linear + 1], 0.0, 0.0, 0.0]
    }

    /// The direction of the nozzle on the part at readings of the rotary axes, and how it changes with each of them.
    fn direction(&self, readings: &[f64; 2]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
        // Seen from the part, a table axis turns the nozzle the other way.
        let sense = self.rotary.map(|axis| if axis.is_table { -1.0 } else { 1.0 });
        let turned = [0, 1].map(|k| {
            let turned = self.rotary[k].turned(readings[k]);
            if self.rotary[k].is_table { back(turned) } else { turned }
        });
        let [first, second] = &self.rotary;
        let inner = second.direction(turned[1], &self.nozzle);
        let direction = first.direction(turned[0], &inner);
        let rates = [
            first.axis.cross(&direction) * sense[0],
            first.direction(turned[0], &second.axis.cross(&inner)) * sense[1],
        ];
        (direction, rates)
    }

    /// Readings of the rotary axes that point the nozzle in a direction on the part, from readings nearby, and by which angle they miss it: what a controller
    /// does that is given vectors. By damped steps (Levenberg 1944, as in `inverse`), so that a pole does not throw the axes away.
    pub fn readings(&self, wanted: &Vector3<f64>, near: &[f64; 2]) -> ([f64; 2], f64) {
        let angle = |direction: &Vector3<f64>| direction.cross(wanted).norm().atan2(direction.dot(wanted));
        let (mut best, mut damping) = (*near, 0.0f64);
        let (mut direction, mut rates) = self.direction(&best);
        for _ in 0..STEPS {
            let off = angle(&direction);
            if off <= REACHED {
                break;
            }
            let left = wanted - direction;
            let [a, b, c] =
                [rates[0].norm_squared() + damping, rates[0].dot(&rates[1]), rates[1].norm_squared() + damping];
            let [x, y] = [rates[0].dot(&left), rates[1].dot(&left)];
            let determinant = a * c - b * b;
            let step = [(c * x - b * y) / determinant, (a * y - b * x) / determinant];
            let size = step[0].abs().max(step[1].abs());
            let next = [0, 1].map(|k| best[k] + step[k] * (MAX_STEP / size).min(1.0));
            let there = self.direction(&next);
            if size.is_finite() && angle(&there.0) < off {
                (best, (direction, rates)) = (next, there);
                damping *= 0.1;
            } else if damping > MAX_DAMPING {
                break;
            } else {
                damping = (10.0 * damping).max(DAMPING);
            }
        }
        (best, angle(&direction))
    }
}

/// A direction this near counts as reached, in radians.
const REACHED: f64 = 1e-10;
/// Most steps; from readings nearby four do.
const STEPS: usize = 100;
/// Damping to begin with and where it ends, as squares of radians a radian.
const DAMPING: f64 = 1e-6;
const MAX_DAMPING: f64 = 1e4;
/// Largest change of a reading in a step, in radians.
const MAX_STEP: f64 = 0.5;

fn limits(model: &MachineModel) -> Limits {
    let mut limits = Limits::NONE;
    for (k, axis) in model.linear.iter().enumerate() {
        [limits.lower[k], limits.upper[k]] = axis.range_mm;
        limits.speed[k] = axis.max_speed_mm_s;
        limits.acceleration[k] = axis.max_acceleration_mm_s2.unwrap_or(f64::INFINITY);
    }
    for (k, axis) in (model.linear.len()..).zip(&model.rotary) {
        if let Some([low, high]) = axis.range_deg.filter(|_| !axis.endless) {
            (limits.lower[k], limits.upper[k]) = (low.to_radians(), high.to_radians());
        }
        limits.speed[k] = axis.max_speed_deg_s.to_radians();
        limits.acceleration[k] = axis.max_acceleration_deg_s2.map_or(f64::INFINITY, f64::to_radians);
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FILES: [&str; 6] = [
        TABLE,
        include_str!("../../machines/bc-table-tcp.json"),
        include_str!("../../machines/head-head-gantry.json"),
        include_str!("../../machines/klipper-tilting-head.json"),
        include_str!("../../machines/open5x-table.json"),
        include_str!("../../machines/polar-tilting-head.json"),
    ];

    fn axes_of(linear: usize, at: &[f64; 3], angles: &[f64; 2]) -> Axes {
        let mut axes = [0.0; MAX_AXES];
        axes[..linear].copy_from_slice(&at[..linear]);
        (axes[linear], axes[linear + 1]) = (angles[0], angles[1]);
        axes
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(64) })]

        /// The machine of the planner has another derivation. Pivots, zeros and origins are moved about, so that none of them is without effect.
        #[test]
        fn the_nozzle_is_where_the_library_has_it(
            at in prop::array::uniform3(-90f64..90.0), angles in prop::array::uniform2(-1.5f64..1.5), off in prop::array::uniform9(-20f64..20.0)
        ) {
            for text in FILES {
                let mut model = MachineModel::from_json(text.as_bytes()).unwrap();
                for (k, axis) in model.rotary.iter_mut().enumerate() {
                    let point = axis.point_mm.get_or_insert_default();
                    (0..3).for_each(|c| point[c] += off[3 * k + c]);
                    axis.zero_deg += off[6 + k];
                }
                model.part_origin_mm[2] += off[8];
                let library = machine::FiveAxis::new(model.clone()).unwrap();
                let machine = FiveAxis::new(&model);
                let axes = axes_of(machine.linear, &at, &angles);
                let pose = if machine.knows_tip { machine.nozzle_on_part(&machine.under_tip(&axes)) } else { machine.nozzle_on_part(&axes) };
                let said = [axes[0], axes[1], axes[2], axes[3], axes[4]];
                let (tip, direction) = library.forward(&said);
                prop_assert!((pose.tip - tip).norm() < 1e-9, "{} {} {tip}", model.name, pose.tip);
                prop_assert!((pose.axis - direction.into_inner()).norm() < 1e-12, "{}", model.name);
                if machine.knows_tip {
                    let (joints, own) = (library.joints(&said), machine.under_tip(&axes));
                    prop_assert!((0..5).all(|k| (joints[k] - own[k]).abs() < 1e-9), "{} {joints:?} {own:?}", model.name);
                }
            }
        }

        #[test]
        fn under_the_tip_and_back(at in prop::array::uniform3(-90f64..90.0), angles in prop::array::uniform2(-1.5f64..1.5)) {
            for text in FILES {
                let machine = FiveAxis::from_json(text.as_bytes()).unwrap();
                let axes = axes_of(machine.linear, &at, &angles);
                let again = machine.under_tip(&machine.of_tip(&axes));
                prop_assert!((0..MAX_AXES).all(|k| (axes[k] - again[k]).abs() < 1e-9), "{} {axes:?} {again:?}", machine.name);
            }
        }

        #[test]
        fn a_direction_is_reached_again(angles in prop::array::uniform2(-1.4f64..1.4), off in prop::array::uniform2(-0.3f64..0.3)) {
            for text in FILES {
                let machine = FiveAxis::from_json(text.as_bytes()).unwrap();
                let (wanted, _) = machine.direction(&angles);
                let (found, missed) = machine.readings(&wanted, &[angles[0] + off[0], angles[1] + off[1]]);
                prop_assert!(missed < 1e-8, "{} {missed} {found:?}", machine.name);
            }
        }
    }

    #[test]
    fn the_table_is_that_of_the_writer() {
        let (table, machine) = (curvlay_toolpath::gcode::RotaryTable::default(), FiveAxis::table().unwrap());
        let (tip, direction) = table.part_point(&Point3::new(3.0, -4.0, 5.0), [0.3, -1.1]);
        let pose = machine.nozzle_on_part(&[3.0, -4.0, 5.0, -1.1, 0.3, 0.0, 0.0, 0.0]);
        assert!((pose.tip - tip).norm() < 1e-12 && (pose.axis - direction.into_inner()).norm() < 1e-12);
        assert_eq!((machine.letters.iter().collect::<String>(), machine.linear), ("XYZCB".to_owned(), 3));
        let fault = FiveAxis::from_json(&TABLE.replacen("\"C\"", "\"X\"", 1).into_bytes()).unwrap_err().to_string();
        assert!(fault.contains("rotary[0].letter"), "{fault}");
    }
}
