//! Least-distortion maps: a patch of any triangle mesh unrolled into the plane of the drawing.
//!
//! B. Levy, S. Petitjean, N. Ray and J. Maillot, "Least squares conformal maps for automatic texture atlas generation", ACM TOG 21(3),
//! 2002. L. Liu, L. Zhang, Y. Xu, C. Gotsman and S. J. Gortler, "A local/global approach to mesh parameterization", Computer Graphics
//! Forum 27(5), 2008. Brooks names surfaces of any shape as future work (section 6.2).
//!
//! Departs from them: the patch is what looks up around the z axis; it comes to lie with its pole in the origin, turned as the drawing is.
//!
//! * `mesh`: the whole. `patch`: what looks up. `energy`: the maps.

mod energy;
mod error;
mod mesh;
mod patch;

pub use error::UnrollError;
pub use mesh::{UnrollKind, UnrollOptions, UnrolledMesh};
