//! What rounding may cost in a scene: the bounds by which its tests are on the safe side. Lengths are below [`super::MAX_COORDINATE`], where
//! a coordinate has an error of about 1e-10 mm. With less, a contact could be missed; with more, a gap is taken for a contact.

/// More than sums of coordinates and lengths along a chain of links lose, in millimetres.
pub(super) const CHAIN_MM: f64 = 1e-6;

/// More than sums of a few coordinates lose, in millimetres: boxes of meshes are grown by it.
pub(super) const BOX_MM: f64 = 1e-9;

/// More than coordinates that come through poses, and gaps between boxes and bodies of them, lose, in millimetres.
pub(super) const GAP_MM: f64 = 1e-8;

/// More than sums of products lose, as a share: of arms and turns in sweeps, and of `h (|b1| + 2 |b2| + 3 |b3|)` in errors of the `A`, `B`
/// and `C` of a cubic.
pub(super) const SHARE: f64 = 1e-12;
