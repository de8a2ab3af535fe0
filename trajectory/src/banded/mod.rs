//! Symmetric banded systems: factored without pivoting, solved in place.
//!
//! Four forms, and each has its own arithmetic, as results keep every bit:
//!
//! * [`BlockTridiagonal`]: quasi-definite, in blocks of any size, `L D L^T`. The quadratic programs of [`qp`](crate::qp).
//! * [`Cholesky`]: positive definite, of any width, `L L^T`. The search for shortest times over free parameters.
//! * [`Pentadiagonal`]: positive definite, two entries beside the diagonal, `L D L^T`. Timing along a path: a dozen systems a program
//!   with thousands of unknowns each, and the loop over a fixed width is what makes it fast.
//! * [`Tridiagonal`]: one entry beside the diagonal, `L D L^T`. Splines.

mod block;
mod cholesky;
mod pentadiagonal;
mod tridiagonal;

pub(crate) use block::{BlockTridiagonal, inner};
pub(crate) use cholesky::Cholesky;
pub(crate) use pentadiagonal::Pentadiagonal;
pub(crate) use tridiagonal::Tridiagonal;
