//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! The contact space: postures in which the tool's tip is on the working surface.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.4.2: `dist(f(q), S)` is
//! [`ContactSpace::gap`], the projection operator of Eq. 4.15 is [`project`].

use crate::vectors::{dot, square};

/// Where a tool touches a working surface, and what collides there; given by the caller.
pub trait ContactSpace<const N: usize>: Sync {
    /// Whether anything touches that must not: the exact answer.
    fn collides(&self, joints: &[f64; N]) -> bool;

    /// How far the tip is from the working surface, in millimetres: 0 on it, and best with a sign, so that it is smooth
    /// there. Not finite where there is no answer.
    fn gap(&self, joints: &[f64; N]) -> f64;

    /// The gap and its derivative by each joint; by central differences unless there is something better.
    fn gap_gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        // In radians: balances what the formula leaves out against rounding, for gaps of metres.
        const STEP: f64 = 1e-5;
        let slope = |j: usize| {
            let at = |step: f64| {
                let mut moved = *joints;
                moved[j] += step;
                self.gap(&moved)
            };
            (at(STEP) - at(-STEP)) / (2.0 * STEP)
        };
        (self.gap(joints), std::array::from_fn(slope))
    }

    /// A posture with the tip on the surface, from numbers drawn evenly from `[0, 1)`: a point of the surface, an angle
    /// about its normal, one of the solutions of the inverse. `None` when that point is out of reach.
    fn sample(&self, random: &mut dyn FnMut() -> f64) -> Option<[f64; N]>;
}

impl<const N: usize, C: ContactSpace<N> + ?Sized> ContactSpace<N> for &C {
    fn collides(&self, joints: &[f64; N]) -> bool {
        (**self).collides(joints)
    }

    fn gap(&self, joints: &[f64; N]) -> f64 {
        (**self).gap(joints)
    }

    fn gap_gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        (**self).gap_gradient(joints)
    }

    fn sample(&self, random: &mut dyn FnMut() -> f64) -> Option<[f64; N]> {
        (**self).sample(random)
    }
}

/// A contact space made of closures.
/// ```
/// use curvlay_trajectory::indicator::{ContactFn, ContactSpace, project};
/// // Two sliding joints: the tip is at (x, y), the surface is the circle of radius 100; left of x = 0 it collides.
/// let circle = ContactFn {
///     collides: |q: &[f64; 2]| q[0] < 0.0,
///     gap: |q: &[f64; 2]| q[0].hypot(q[1]) - 100.0,
///     sample: |random: &mut dyn FnMut() -> f64| {
///         let turn = std::f64::consts::TAU * random();
///         Some([100.0 * turn.cos(), 100.0 * turn.sin()])
///     },
/// };
/// let [x, y] = project(&circle, &[120.0, 160.0], 1e-6).unwrap();
/// assert!((x - 60.0).abs() < 1e-3 && (y - 80.0).abs() < 1e-3 && circle.gap(&[x, y]).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ContactFn<C, G, S> {
    /// Whether a posture collides.
    pub collides: C,
    /// The gap.
    pub gap: G,
    /// A random posture on contact.
    pub sample: S,
}

impl<const N: usize, C, G, S> ContactSpace<N> for ContactFn<C, G, S>
where
    C: Fn(&[f64; N]) -> bool + Sync,
    G: Fn(&[f64; N]) -> f64 + Sync,
    S: Fn(&mut dyn FnMut() -> f64) -> Option<[f64; N]> + Sync,
{
    fn collides(&self, joints: &[f64; N]) -> bool {
        (self.collides)(joints)
    }

    fn gap(&self, joints: &[f64; N]) -> f64 {
        (self.gap)(joints)
    }

    fn sample(&self, random: &mut dyn FnMut() -> f64) -> Option<[f64; N]> {
        (self.sample)(random)
    }
}

/// Steps along the surface; it takes three to ten where that is smooth.
const MAX_STEPS: usize = 60;
/// Halvings of a step.
const MAX_HALVINGS: usize = 30;
/// The nearest posture is found when what is left to go along the surface is shorter than this, in radians.
const STILL: f64 = 1e-6;

/// The posture on contact (gap within `tolerance`) that is nearest to `joints`, or a nearby one where the surface is
/// rough; `None` when no way leads onto it.
///
/// Solves Eq. 4.15: by Newton's method onto the surface, then along it, each step in the direction in which its tangent
/// plane comes nearer to `joints`. A step is as long as the last one says that it should be (J. Barzilai, J. Borwein,
/// *Two-point step size gradient methods*, IMA J. Numer. Anal. 8, 1988), and halved until it comes nearer. The paper
/// uses sequential quadratic programming, which with one constraint comes to the same.
pub fn project<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    joints: &[f64; N],
    tolerance: f64,
) -> Option<[f64; N]> {
    let (mut at, slope) = onto(space, *joints, tolerance)?;
    let mut along = tangential(joints, &at, &slope);
    let mut stride = 1.0;
    for _ in 0..MAX_STEPS {
        if dot(&along, &along) < STILL * STILL {
            break;
        }
        let before = square(joints, &at);
        let mut next = None;
        for _ in 0..MAX_HALVINGS {
            let moved = std::array::from_fn(|j| at[j] + stride * along[j]);
            next = onto(space, moved, tolerance).filter(|(next, _)| square(joints, next) < before);
            if next.is_some() {
                break;
            }
            stride *= 0.5;
        }
        let Some((reached, reached_slope)) = next else { break };
        let left = tangential(joints, &reached, &reached_slope);
        let (step, change): ([f64; N], [f64; N]) =
            (std::array::from_fn(|j| reached[j] - at[j]), std::array::from_fn(|j| along[j] - left[j]));
        let curved = dot(&step, &change);
        // Where nothing curves as it should, the plain step of a flat surface is as good a guess as any.
        stride = if curved > 0.0 { (dot(&step, &step) / curved).clamp(1e-3, 1e3) } else { 1.0 };
        (at, along) = (reached, left);
    }
    Some(at)
}

/// What is left to go from `at` to `joints`, without its part along the slope.
fn tangential<const N: usize>(joints: &[f64; N], at: &[f64; N], slope: &[f64; N]) -> [f64; N] {
    let back: [f64; N] = std::array::from_fn(|j| joints[j] - at[j]);
    let steep = dot(slope, slope);
    let share = if steep > 0.0 { dot(slope, &back) / steep } else { 0.0 };
    std::array::from_fn(|j| back[j] - slope[j] * share)
}

/// The shortest steps onto the surface, by Newton's method: where they lead, and the slope of the gap there.
fn onto<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    mut at: [f64; N],
    tolerance: f64,
) -> Option<([f64; N], [f64; N])> {
    for _ in 0..MAX_STEPS {
        let (gap, slope) = space.gap_gradient(&at);
        if gap.abs() <= tolerance {
            return Some((at, slope));
        }
        let steep = dot(&slope, &slope);
        if !(gap.is_finite() && steep.is_finite() && steep > 0.0) {
            return None;
        }
        at = std::array::from_fn(|j| at[j] - slope[j] * gap / steep);
    }
    None
}
