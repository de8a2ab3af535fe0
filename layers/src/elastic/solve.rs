//! Conjugate gradients, preconditioned by a V-cycle.
//!
//! M. R. Hestenes, E. Stiefel, "Methods of conjugate gradients for solving linear systems", J. Res. Nat. Bur. Standards 49(6), 1952, section 3.

use super::multigrid::{Multigrid, add, dot, free, minus};
use super::operator::Triple;
use crate::parallel::{fill, sum, update};

/// How it went.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) iterations: u32,
    /// Norm of the residual, as a share of that of the forces.
    pub(super) residual: f64,
    /// Whether the callback stopped it.
    pub(super) cancelled: bool,
}

/// Finds `x`, which is 0 in `fixed` components, for the forces `b`, which are 0 there.
///
/// * `go_on`: called with the residual after each iteration; false stops.
pub(super) fn conjugate_gradients(
    multigrid: &mut Multigrid,
    b: &[Triple],
    fixed: &[u8],
    tolerance: f64,
    max_iterations: u32,
    go_on: &dyn Fn(f64) -> bool,
) -> (Vec<Triple>, Outcome) {
    let len = b.len();
    let product = |a: &[Triple], b: &[Triple]| sum(len, |node| dot(a[node], b[node]));
    let mut x = vec![[0.0; 3]; len];
    let mut outcome = Outcome { iterations: 0, residual: 0.0, cancelled: false };
    let norm = product(b, b).sqrt();
    if norm <= 0.0 {
        return (x, outcome);
    }
    let mut r = b.to_vec();
    let (mut z, mut moved) = (Vec::new(), vec![[0.0; 3]; len]);
    let mut p = vec![[0.0; 3]; len];
    let mut before: Option<f64> = None;
    outcome.residual = 1.0;
    while outcome.residual > tolerance && outcome.iterations < max_iterations {
        multigrid.cycle(&r, fixed, &mut z);
        let now = product(&r, &z);
        let share = before.map_or(0.0, |before| now / before);
        update(&mut p, |node, p| *p = [0, 1, 2].map(|k| z[node][k] + share * p[k]));
        let operator = multigrid.operator();
        fill(&mut moved, |node| free(fixed, node, operator.at(node, &p)));
        let length = now / product(&p, &moved);
        update(&mut x, |node, x| add(x, p[node].map(|k| length * k)));
        update(&mut r, |node, r| *r = minus(*r, moved[node].map(|k| length * k)));
        before = Some(now);
        outcome.iterations += 1;
        outcome.residual = product(&r, &r).sqrt() / norm;
        if !outcome.residual.is_finite() {
            break;
        }
        if !go_on(outcome.residual) {
            outcome.cancelled = true;
            break;
        }
    }
    (x, outcome)
}
