//! One piece of a cubic spline: its extremes in closed form.

/// A value and when it occurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// When, in seconds.
    pub time: f64,
    /// The value, with its sign.
    pub value: f64,
}

/// `q + v s + a s^2 / 2 + j s^3 / 6` for `s` from 0 to `step`, beginning at `time`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub time: f64,
    pub step: f64,
    pub q: f64,
    pub v: f64,
    pub a: f64,
    pub j: f64,
}

impl Piece {
    pub fn position(&self, s: f64) -> f64 {
        self.q + s * (self.v + s * (self.a / 2.0 + s * self.j / 6.0))
    }

    pub fn velocity(&self, s: f64) -> f64 {
        self.v + s * (self.a + s * self.j / 2.0)
    }

    pub fn acceleration(&self, s: f64) -> f64 {
        self.a + s * self.j
    }

    fn peak(&self, s: f64, value: f64) -> Peak {
        Peak { time: self.time + s, value }
    }

    fn inside(&self, s: f64) -> Option<f64> {
        (s > 0.0 && s < self.step).then_some(s)
    }

    /// Where positions may be extreme: the ends, and where the velocity passes through zero.
    pub fn positions(&self) -> impl Iterator<Item = Peak> {
        // Roots of j/2 s^2 + a s + v without a difference of like numbers.
        let square = self.a * self.a - 2.0 * self.j * self.v;
        let roots = if square >= 0.0 {
            let sum = -(self.a + square.sqrt().copysign(self.a));
            [self.inside(sum / self.j), self.inside(2.0 * self.v / sum)]
        } else {
            [None; 2]
        };
        let at = [Some(0.0), Some(self.step)].into_iter().chain(roots).flatten();
        at.map(|s| self.peak(s, self.position(s)))
    }

    /// Where speeds may be extreme: the ends, and where the acceleration passes through zero.
    pub fn velocities(&self) -> impl Iterator<Item = Peak> {
        let at = [Some(0.0), Some(self.step), self.inside(-self.a / self.j)].into_iter().flatten();
        at.map(|s| self.peak(s, self.velocity(s)))
    }

    /// Accelerations are extreme at the ends.
    pub fn accelerations(&self) -> impl Iterator<Item = Peak> {
        [0.0, self.step].into_iter().map(|s| self.peak(s, self.acceleration(s)))
    }

    /// The jerk is one number on the piece.
    pub fn jerk(&self) -> Peak {
        self.peak(0.0, self.j)
    }
}
