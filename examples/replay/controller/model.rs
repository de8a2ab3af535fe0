//! The numbers of a controller. Makers publish few of them: each default says where it comes from.

use clap::ValueEnum;

/// Whose controller it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Maker {
    /// Universal Robots
    Ur,
    /// ABB
    Abb,
    /// KUKA
    Kuka,
    /// Fanuc
    Fanuc,
    /// A printer with G-code
    Gcode,
}

/// How speed changes along a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Acceleration jumps
    Trapezoid,
    /// Acceleration rises over a time, so that jerk is limited
    SCurve,
}

/// How an arm follows a stream of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Follower {
    /// Exactly
    None,
    /// As a filter of the first order
    First,
    /// As a critically damped filter of the second order
    Second,
}

/// A controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerModel {
    /// How speed changes.
    pub profile: Profile,
    /// How long acceleration takes to rise, in seconds, with an S-curve.
    pub ramp_s: f64,
    /// Moves that it knows ahead.
    pub look_ahead: usize,
    /// Greatest acceleration of the tip on lines, mm/s2.
    pub tip_mm_s2: f64,
    /// Greatest speed of the tip on lines, mm/s.
    pub tip_mm_s: f64,
    /// Greatest acceleration of a joint that the controller asks for, rad/s2; never more than the limit of the machine.
    pub joint_rad_s2: f64,
    /// How far a corner of G-code may be cut, in millimetres.
    pub corner_mm: f64,
    /// Where in a blend signals come, as a share of it.
    pub signal_share: f64,
    /// The filter of a stream.
    pub follower: Follower,
    /// By how much an arm is behind its stream, in seconds.
    pub lag_s: f64,
    /// Programmed speeds are multiplied by this share.
    pub speed_share: f64,
    /// Ticks a second.
    pub rate_hz: f64,
}

/// What URScript takes as look-ahead time, in seconds, and as gain of `servoj` (*The URScript Programming Language*).
pub const LOOKAHEAD_S: [f64; 2] = [0.03, 0.2];
/// See [`LOOKAHEAD_S`].
pub const GAIN: [f64; 2] = [100.0, 2000.0];
/// Gain of `servoj` at which an arm is behind its stream by the look-ahead time alone.
const FULL_GAIN: f64 = GAIN[1];

impl ControllerModel {
    /// What is known, or estimated, of a maker's controllers.
    ///
    /// * UR: trapezoids, 1.2 m/s2 and 1.4 rad/s2 (defaults of `movel` and `movej`, *The URScript Programming Language*); 125 Hz (CB series);
    ///   `lookahead_time` 0.03 s. The look-ahead is an estimate.
    /// * ABB: acceleration of the path as the program has it (`PathAccLim`), else 10 m/s2 (an estimate for small arms); an S-curve, as ABB's `AccSet`
    ///   has a ramp, of 0.05 s (an estimate).
    /// * KUKA: acceleration of the path 2 m/s2, the `$ACC.CP` of our programs; five moves ahead (`$ADVANCE` is at most 5); an S-curve as ABB's (an estimate).
    /// * Fanuc: 10 m/s2 and an S-curve, as ABB's (estimates: a program has shares of what the arm can do).
    /// * G-code: trapezoids over 16 moves (Marlin, `BLOCK_BUFFER_SIZE`), corners cut by 0.05 mm (an estimate: Marlin's junction deviation is 0.013 mm,
    ///   a P of `G64` in LinuxCNC is commonly 0.01 to 0.1 mm).
    pub fn of(maker: Maker) -> Self {
        let base = ControllerModel {
            profile: Profile::Trapezoid,
            ramp_s: 0.05,
            look_ahead: 16,
            tip_mm_s2: 1200.0,
            tip_mm_s: 1000.0,
            joint_rad_s2: 1.4,
            corner_mm: 0.05,
            signal_share: 0.0,
            follower: Follower::Second,
            lag_s: 0.03,
            speed_share: 1.0,
            rate_hz: 125.0,
        };
        let smooth = ControllerModel {
            profile: Profile::SCurve,
            tip_mm_s2: 10_000.0,
            tip_mm_s: 5000.0,
            joint_rad_s2: f64::INFINITY,
            signal_share: 0.5,
            ..base
        };
        match maker {
            Maker::Ur => base,
            Maker::Abb => smooth,
            // A trigger at the end of a line comes in the middle of its arc.
            Maker::Kuka => ControllerModel { tip_mm_s2: 2000.0, look_ahead: 5, ..smooth },
            // Behind CNT a signal comes as the corner begins.
            Maker::Fanuc => ControllerModel { signal_share: 0.0, ..smooth },
            Maker::Gcode => ControllerModel {
                tip_mm_s2: f64::INFINITY,
                tip_mm_s: f64::INFINITY,
                joint_rad_s2: f64::INFINITY,
                signal_share: 0.5,
                ..base
            },
        }
    }

    /// The lag of a stream by look-ahead time and gain. A loop of the second order is slower by the root of its stiffness.
    pub fn lag_of(lookahead_s: f64, gain: f64) -> f64 {
        lookahead_s * (FULL_GAIN / gain).max(1.0).sqrt()
    }

    /// Time between two ticks.
    pub fn tick_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Ticks over which an S-curve averages; 0 for trapezoids.
    pub fn ramp_ticks(&self) -> usize {
        match self.profile {
            Profile::Trapezoid => 0,
            Profile::SCurve => (self.ramp_s * self.rate_hz).round() as usize,
        }
    }
}
