//! What the checker asks of the workcell and the part.

use nalgebra::{Isometry3, Point3, UnitVector3};

/// When and where on its path the nozzle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The motion, counted from 0.
    pub motion: usize,
    /// Seconds, as in [`super::CheckedMotion::times`].
    pub time: f64,
    /// Whether the path is being followed; `false` on travels, and before and after
    /// [`super::CheckedMotion::printing`].
    pub printing: bool,
    /// The last path point passed (0 before the first and on travels).
    pub point: usize,
    /// How far it is from there to the next point, 0 to 1.
    pub share: f64,
}

/// What the nozzle touches.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// How deep, in millimetres; compared with [`super::CheckOptions::max_depth_mm`].
    pub depth_mm: f64,
    /// What, in words.
    pub what: String,
}

/// The workcell and the part as they are, for a checker: kinematics, contact, sweeps.
///
/// [`PrintSceneFn`] makes one of closures. Answers must depend on the arguments alone, or reports are not reproducible.
pub trait PrintScene<const N: usize>: Sync {
    /// The nozzle in the frame of the part, in millimetres: the tip, and the z axis along the nozzle, away from the tip.
    /// `None` where the joints have no pose.
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>>;

    /// How deep the nozzle is in what is built by then; `None` if it touches nothing that it must not touch.
    fn contact(&self, moment: &Moment, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<Contact>;

    /// What may be touched on a piece of a motion (piece `k` goes from knot `k` to `k + 1`), given by its Bezier control
    /// polygon in joint space; `None` only if the piece is proven free.
    fn sweep(&self, motion: usize, piece: usize, control: &[[f64; N]; 4]) -> Option<String>;
}

/// A [`PrintScene`] made of three closures.
#[derive(Clone, Copy, Debug)]
pub struct PrintSceneFn<P, C, S> {
    /// As [`PrintScene::nozzle`].
    pub nozzle: P,
    /// As [`PrintScene::contact`].
    pub contact: C,
    /// As [`PrintScene::sweep`].
    pub sweep: S,
}

impl<const N: usize, P, C, S> PrintScene<N> for PrintSceneFn<P, C, S>
where
    P: Fn(&[f64; N]) -> Option<Isometry3<f64>> + Sync,
    C: Fn(&Moment, &Point3<f64>, &UnitVector3<f64>) -> Option<Contact> + Sync,
    S: Fn(usize, usize, &[[f64; N]; 4]) -> Option<String> + Sync,
{
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        (self.nozzle)(joints)
    }

    fn contact(&self, moment: &Moment, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<Contact> {
        (self.contact)(moment, tip, axis)
    }

    fn sweep(&self, motion: usize, piece: usize, control: &[[f64; N]; 4]) -> Option<String> {
        (self.sweep)(motion, piece, control)
    }
}
