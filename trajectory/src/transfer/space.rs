//! What a planner of transfers asks of the workcell.

/// Which motions are free; given by the caller, best as a proof for the motion as a whole.
///
/// Any `Fn(&[f64; N], &[f64; N]) -> bool + Sync` is one.
pub trait FreeSpace<const N: usize>: Sync {
    /// Whether the straight motion in joint space from one posture to another is free, ends included.
    fn free(&self, from: &[f64; N], to: &[f64; N]) -> bool;

    /// Whether a posture is free: asked along a line before the line is, because in clutter it often settles the matter.
    /// The search goes by it, so it should be cheap; that it is free proves nothing for the motion.
    fn posture_free(&self, joints: &[f64; N]) -> bool {
        self.free(joints, joints)
    }

    /// What is in the way at a posture, in words; `None` when it is free.
    fn obstruction(&self, joints: &[f64; N]) -> Option<String> {
        (!self.posture_free(joints)).then(|| "something".into())
    }
}

impl<const N: usize, F: Fn(&[f64; N], &[f64; N]) -> bool + Sync> FreeSpace<N> for F {
    fn free(&self, from: &[f64; N], to: &[f64; N]) -> bool {
        self(from, to)
    }
}
