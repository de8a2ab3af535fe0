//! When a cell can be built: what it stands on, and what shadows it.
//!
//! Data first ([`rules`], [`mould`], [`platform`]), then the hull of what is built ([`body`]), what stands on the platform ([`supported`]), which cells lie at the
//! surface of the hull ([`shell`]), and which ones are about to be shadowed ([`accessibility`]).

pub(crate) mod accessibility;
pub(crate) mod body;
pub(crate) mod mould;
mod on_mould;
pub(crate) mod platform;
pub(crate) mod rules;
pub(crate) mod runs;
pub(crate) mod shell;
pub(crate) mod supported;
