//! Parts cut by planes, each printed along the normal of its base plane: the fine decomposition of RoboFDM.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.4.3, after C. Wu, C. Dai, G. Fang, Y.-J. Liu and
//! C. C. L. Wang, "RoboFDM: a robotic system for support-free fabrication using FDM", ICRA 2017. Of the parts with the largest risky
//! area the one is cut whose best plane saves most (Eq. 2.2), again and again.
//!
//! Departures: it starts from the whole solid, not from a coarse decomposition by skeleton (Phases I and II). Below a plane there must be one piece,
//! which keeps the base; every piece above becomes a part. A plane must not face down in the part that it cuts, so that the
//! section itself needs no support.

mod cutting;
mod planes;

pub use cutting::{CuttingError, CuttingOptions, PlaneDecomposition, PlanePart, decompose_by_planes};
