//! What a piece of bead is for, and runs of a kind along a curve.

/// What a piece of bead is for. Machines lay walls slower than what is inside, and viewers show each kind in its own colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum BeadKind {
    /// Along the boundary of a layer: of a layer that is filled solid the outermost contour, of others all contours that were asked
    /// for.
    Wall,
    /// The inside of a layer that is filled solid.
    #[default]
    Solid,
    /// Solid because the layer is near the outside of the part: bottoms and tops over and under sparse infill.
    Skin,
    /// A skin over sparse infill, which is no ground. What lies between two bridges and is no longer than five beads is one of them, and so
    /// with what lies between two skins: machines change fan and speed at each.
    Bridge,
    /// Sparse infill.
    Infill,
    /// Support: not of the part, to be broken off ([`FilledLayer::with_support`](crate::fill::FilledLayer::with_support)).
    Support,
    /// Sparse infill of support.
    SparseSupport,
    /// Support over its own sparse infill, as a bridge is over that of the part.
    SupportBridge,
}

impl BeadKind {
    /// Whether it is sparse infill, of the part or of support: it lies on something here and there only.
    pub fn is_sparse(self) -> bool {
        matches!(self, BeadKind::Infill | BeadKind::SparseSupport)
    }

    /// Whether it goes over sparse infill, of the part or of support: it lies on something here and there only.
    pub fn is_bridge(self) -> bool {
        matches!(self, BeadKind::Bridge | BeadKind::SupportBridge)
    }

    /// Whether it is not of the part.
    pub fn is_support(self) -> bool {
        matches!(self, BeadKind::Support | BeadKind::SparseSupport | BeadKind::SupportBridge)
    }
}
