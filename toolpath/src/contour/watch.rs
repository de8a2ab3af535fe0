//! Whether to go on.

use crate::path::PathError;

/// What asks whether to go on.
pub(super) type Watch<'a> = &'a dyn Fn() -> Result<(), PathError>;
