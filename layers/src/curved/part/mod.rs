//! A part in layers, in one call: [`Workpiece`](workpiece::Workpiece).

mod below;
pub(crate) mod best;
mod coherent;
pub(crate) mod complete;
mod contact;
pub(crate) mod directions;
mod distance;
pub(crate) mod guides;
pub(crate) mod heights;
pub(crate) mod workpiece;
