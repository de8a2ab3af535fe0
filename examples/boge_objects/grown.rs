//! An order that was grown.

use curvlay_layers::curved::{AuditReport, Growth};

/// An order, and what its audit says.
pub struct Run {
    pub growth: Growth,
    pub audit: AuditReport,
}
