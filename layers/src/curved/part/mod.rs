//! A part in layers, in one call: [`Workpiece`](workpiece::Workpiece).
//!
//! Data first: [`workpiece`], [`options`], [`guides`], [`error`]; then orders ([`by_hulls`], [`by_distance`]), their [`surfaces`], and all of it together ([`layered`]).

mod below;
pub(super) mod best;
mod by_distance;
mod by_hulls;
mod contact;
pub(super) mod directions;
pub(super) mod error;
pub(super) mod guides;
pub(super) mod heights;
pub(super) mod layer_surfaces;
pub(super) mod layered;
mod measured;
pub(super) mod options;
pub(super) mod order;
pub(super) mod planned;
mod sheets;
pub(super) mod support;
mod surfaces;
pub(super) mod workpiece;
