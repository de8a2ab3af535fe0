//! Machines whose nozzle stands still in direction while the table under it tilts and turns.
//!
//! The turning axis `u` (C) stands on the tilting one `t` (B), the part on the turning one. With `R_w(a)` the rotation by
//! `a` about `w` through the centre of its axis, a point `p` of the part is in the machine at `R_t(b) R_u(c) p`, and the
//! angles must bring the direction `d` of the nozzle to `n`, the direction that it has in the machine:
//! `R_t(b) R_u(c) d = n`. So `e = R_u(c) d = R_t(-b) n` is where two circles on the sphere meet, one about `u` through
//! `d` and one about `t` through `n`: `e = alpha t + beta u + gamma t x u`, the sign of `gamma` free (the second
//! subproblem of Paden and Kahan; Murray, Li, Sastry, *A Mathematical Introduction to Robotic Manipulation*, 1994, 3.2).
//! Of both, in all whole turns within the limits, the one that is reached soonest from the last angles is taken.
//!
//! At the pole, `d` along `u`, any `c` will do: it stays as it is.

use super::{ANGLE_DECIMALS, COORDINATE, within};
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};

/// A rotary axis. At zero its frame is that of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryAxis {
    /// Its letter in the file: A, B, C, U, V or W.
    pub letter: char,
    /// The table turns about this by the right-hand rule when the angle grows; the opposite vector is the opposite sense.
    pub axis: UnitVector3<f64>,
    /// A point of the axis, in the frame of the part with all axes at zero, mm.
    pub centre: Point3<f64>,
    /// Least and greatest angle, radians; infinite when it turns without end.
    pub limits: [f64; 2],
    /// Fastest turning, rad/s: moves that would need more are slowed down.
    pub speed_rad_s: f64,
}

/// A table that turns on a part that tilts, under a nozzle of fixed direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryTable {
    /// The axis that is fixed in the machine. Default B, about y through the origin, -110 to 110 degrees, 1 rad/s.
    pub tilt: RotaryAxis,
    /// The axis that it carries, with the part on it. Default C, about z through the origin, without limits, 2 rad/s.
    pub turn: RotaryAxis,
    /// Direction of the nozzle in the machine, from the tip into it. Default +z.
    pub nozzle: UnitVector3<f64>,
    /// How near to the pole the turning axis stays as it is, radians, 1e-7 to 0.1. The direction is off by as much at
    /// most. Default 1e-5: directions from files of six digits are no better.
    pub pole_rad: f64,
    /// How far the tip may stray from the straight line while axes interpolate, mm, from 1e-3 up; moves are divided until
    /// it does not. Default 0.02; `None` divides nothing.
    pub tolerance_mm: Option<f64>,
}

impl Default for RotaryTable {
    fn default() -> Self {
        let origin = Point3::origin();
        let end = 110f64.to_radians();
        RotaryTable {
            tilt: RotaryAxis {
                letter: 'B',
                axis: Vector3::y_axis(),
                centre: origin,
                limits: [-end, end],
                speed_rad_s: 1.0,
            },
            turn: RotaryAxis {
                letter: 'C',
                axis: Vector3::z_axis(),
                centre: origin,
                limits: [f64::NEG_INFINITY, f64::INFINITY],
                speed_rad_s: 2.0,
            },
            nozzle: Vector3::z_axis(),
            pole_rad: 1e-5,
            tolerance_mm: Some(0.02),
        }
    }
}

/// Below this sine two axes of a machine count as parallel: it would turn about its pole for nearly all directions.
const PARALLEL: f64 = 1e-3;

/// Lengths that count as 1.
const UNIT: [f64; 2] = [1.0 - 1e-6, 1.0 + 1e-6];

/// Square of the sine by which a direction may miss the reach of the axes: 1e-6 rad, the digits of a file.
const MISSED: f64 = 1e-12;

/// The digits of an angle in the file, in radians.
const ANGLE_STEP: f64 = 1e-5 * PI / 180.0;
const _: () = assert!(ANGLE_DECIMALS == 5);

/// Largest angle in a file: 1e9 degrees are some 2.8 million turns.
pub(super) const DEGREES: [f64; 2] = [-1e9, 1e9];

/// To the digits of the file.
pub(super) fn rounded(angle: f64) -> f64 {
    ((angle / ANGLE_STEP).round() * 1e-5).to_radians()
}

impl RotaryAxis {
    fn check(&self, letter: &'static str) -> Result<(), &'static str> {
        let [least, most] = self.limits;
        if !matches!(self.letter, 'A' | 'B' | 'C' | 'U' | 'V' | 'W') {
            Err(letter)
        } else if !within(self.axis.norm(), UNIT) {
            Err("an axis must have the length 1")
        } else if !self.centre.iter().all(|&x| within(x, COORDINATE)) {
            Err("a centre must lie within 1e6 mm")
        } else if !(least < most && least < f64::INFINITY && most > f64::NEG_INFINITY) {
            Err("limits must be a lower and a higher angle")
        } else if !within(self.speed_rad_s, [1e-6, 1e6]) {
            Err("a fastest turning must be from 1e-6 to 1e6 rad/s")
        } else {
            Ok(())
        }
    }

    fn rotation(&self, angle: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&self.axis, angle)
    }

    /// The angle about the axis that brings `from` to `to`, or nearest to it.
    fn angle(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
        let axis = &self.axis;
        axis.dot(&from.cross(to)).atan2(from.dot(to) - axis.dot(from) * axis.dot(to))
    }

    /// The whole turns more or less that bring an angle nearest to `near` within the limits, in digits of the file.
    fn unwound(&self, angle: f64, near: f64) -> Option<f64> {
        let [least, most] = [self.limits[0].max(DEGREES[0].to_radians()), self.limits[1].min(DEGREES[1].to_radians())];
        let mut angle = angle + TAU * ((near - angle) / TAU).round();
        // A limit has no more digits than an angle.
        let slack = 0.5 * ANGLE_STEP;
        if angle < least - slack {
            angle += TAU * ((least - slack - angle) / TAU).ceil();
        } else if angle > most + slack {
            angle -= TAU * ((angle - most - slack) / TAU).ceil();
        }
        within(angle, [least - slack, most + slack]).then(|| rounded(angle))
    }
}

impl RotaryTable {
    pub(super) fn check(&self) -> Result<(), &'static str> {
        self.tilt.check("the letter of the tilting axis must be A, B, C, U, V or W")?;
        self.turn.check("the letter of the turning axis must be A, B, C, U, V or W")?;
        if self.tilt.letter == self.turn.letter {
            Err("two axes with the same letter")
        } else if !within(self.nozzle.norm(), UNIT) {
            Err("the direction of the nozzle must have the length 1")
        } else if self.tilt.axis.cross(&self.turn.axis).norm() < PARALLEL {
            Err("the two axes are parallel")
        } else if self.tilt.axis.cross(&self.nozzle).norm() < PARALLEL {
            Err("the nozzle is parallel to the tilting axis")
        } else if !within(self.pole_rad, [1e-7, 0.1]) {
            Err("`pole_rad` must be from 1e-7 to 0.1")
        } else if self.tolerance_mm.is_some_and(|tolerance| !within(tolerance, [1e-3, 1e6])) {
            Err("`tolerance_mm` must be from 1e-3 to 1e6")
        } else {
            Ok(())
        }
    }

    /// Where a point of the part is in the machine, with the table at these angles (tilt, turn).
    /// ```
    /// use curvlay_toolpath::{gcode::RotaryTable, nalgebra::Point3};
    /// use std::f64::consts::FRAC_PI_2;
    /// let table = RotaryTable::default();
    /// let at = table.machine_point(&Point3::new(10.0, 0.0, 5.0), [FRAC_PI_2, 0.0]);
    /// assert!((at - Point3::new(5.0, 0.0, -10.0)).norm() < 1e-12);
    /// ```
    pub fn machine_point(&self, point: &Point3<f64>, [tilt, turn]: [f64; 2]) -> Point3<f64> {
        let turned = self.turn.centre + self.turn.rotation(turn) * (point - self.turn.centre);
        self.tilt.centre + self.tilt.rotation(tilt) * (turned - self.tilt.centre)
    }

    /// The point of the part that is there, and the direction of the nozzle in the part: the inverse of
    /// [`RotaryTable::machine_point`].
    pub fn part_point(&self, at: &Point3<f64>, [tilt, turn]: [f64; 2]) -> (Point3<f64>, UnitVector3<f64>) {
        let (back, unturn) = (self.tilt.rotation(-tilt), self.turn.rotation(-turn));
        let turned = self.tilt.centre + back * (at - self.tilt.centre);
        let point = self.turn.centre + unturn * (turned - self.turn.centre);
        (point, UnitVector3::new_normalize(unturn * (back * self.nozzle.into_inner())))
    }

    /// The angles (tilt, turn) that bring a direction of the part under the nozzle, to the digits of the file: within the
    /// limits, and of all such those that are reached soonest from `near`. `None` when there are none.
    ///
    /// Within `pole_rad` of the turning axis the turn stays as it is.
    /// ```
    /// use curvlay_toolpath::{gcode::RotaryTable, nalgebra::{UnitVector3, Vector3}};
    /// let table = RotaryTable::default();
    /// let lean = UnitVector3::new_normalize(Vector3::new(1.0, 0.0, 1.0));
    /// // The other pair is 45 and 180 degrees.
    /// let [tilt, turn] = table.angles(&lean, [0.0, 0.0]).ok_or("out of reach")?;
    /// assert!((tilt.to_degrees() + 45.0).abs() < 1e-5 && turn == 0.0);
    /// assert_eq!(table.angles(&Vector3::z_axis(), [tilt, 2.5]).map(|[tilt, _]| tilt), Some(0.0));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn angles(&self, direction: &UnitVector3<f64>, near: [f64; 2]) -> Option<[f64; 2]> {
        let (t, u, n, d) = (&self.tilt.axis, &self.turn.axis, &self.nozzle, direction);
        if u.cross(d).norm() < self.pole_rad {
            let kept = self.turn.unwound(near[1], near[1]).and_then(|turn| {
                let turned = self.turn.rotation(turn) * d.into_inner();
                let tilt = self.tilt.unwound(self.tilt.angle(&turned, n), near[0])?;
                let missed = (self.tilt.rotation(tilt) * turned - n.into_inner()).norm();
                (missed <= self.pole_rad + ANGLE_STEP).then_some([tilt, turn])
            });
            if kept.is_some() {
                return kept;
            }
        }
        let (tu, nt, du) = (t.dot(u), n.dot(t), d.dot(u));
        let cross = t.cross(u);
        let area = cross.norm_squared();
        let (alpha, beta) = ((nt - tu * du) / area, (du - tu * nt) / area);
        let rest = 1.0 - (alpha * alpha + beta * beta + 2.0 * alpha * beta * tu);
        if rest < -MISSED {
            return None;
        }
        let gamma = (rest.max(0.0) / area).sqrt();
        let flat = t.into_inner() * alpha + u.into_inner() * beta;
        let pair = |gamma: f64| {
            let meet = flat + cross * gamma;
            let tilt = self.tilt.unwound(self.tilt.angle(&meet, n), near[0])?;
            Some([tilt, self.turn.unwound(self.turn.angle(d, &meet), near[1])?])
        };
        match (pair(gamma), pair(-gamma)) {
            (Some(a), Some(b)) => Some(if self.seconds(near, b) < self.seconds(near, a) { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// Time that the axes need at their fastest.
    pub(super) fn seconds(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let [tilt, turn] = [(to[0] - from[0]).abs(), (to[1] - from[1]).abs()];
        (tilt / self.tilt.speed_rad_s).max(turn / self.turn.speed_rad_s)
    }

    /// In how many parts a line of the tip must be cut so that it stays within the tolerance while all axes interpolate.
    ///
    /// The line in the machine is `g(s) = R_t R_u p(s)`; a chord of it strays by an eighth of the greatest `|g''|` at
    /// most. With `v` the length of the line, `b`, `c` the turns and `r_c`, `r_b` the greatest distances from the axes:
    /// `|g'| <= c r_c + v` on the turning table, `|g''| <= c^2 r_c + 2 c v` there, and the same once more on the tilting one.
    pub(super) fn parts(&self, from: &Point3<f64>, to: &Point3<f64>, angles: [[f64; 2]; 2]) -> u32 {
        let Some(tolerance) = self.tolerance_mm else { return 1 };
        let [tilt, turn] = [0, 1].map(|axis: usize| (angles[1][axis] - angles[0][axis]).abs());
        let way = (to - from).norm();
        let away = |point: &Point3<f64>| self.turn.axis.cross(&(point - self.turn.centre)).norm();
        let far = |point: &Point3<f64>| (point - self.turn.centre).norm();
        let of_turn = away(from).max(away(to));
        let of_tilt = far(from).max(far(to)) + (self.turn.centre - self.tilt.centre).norm();
        let first = turn * of_turn + way;
        let second = turn * (turn * of_turn + 2.0 * way) + tilt * (tilt * of_tilt + 2.0 * first);
        // Below 2^32: coordinates and turns are bounded, the tolerance is not below 1e-3 mm.
        (second / (8.0 * tolerance)).sqrt().ceil().clamp(1.0, f64::from(u32::MAX)) as u32
    }
}
