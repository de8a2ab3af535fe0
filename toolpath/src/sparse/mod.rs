//! Sparse symmetric systems, for whatever in the crate solves one over the vertices of a mesh.
//!
//! * `cholesky`: the factors of a matrix whose entries are numbers or two by two blocks. `block`: what an entry has to be able to do.

mod block;
mod cholesky;

pub(crate) use cholesky::{Cholesky, Entries};
