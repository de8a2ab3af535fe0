//! What programs are read as, and what they do not say.

use curvlay_toolpath::orientation::ToolPath;

/// What a program lays.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Beads that follow each other, in the order of the program; a path has the number of its extrusion as its curve, and is cut where its layer changes.
    pub paths: Vec<ToolPath>,
    /// Separate extrusions.
    pub starts: u32,
    /// Layers, where the program says or shows them.
    pub layers: Option<u32>,
    /// Filament, in millimetres, where the program has it.
    pub filament_mm: Option<f64>,
    /// Whether it is a layer alone, without what it is laid on.
    pub is_alone: bool,
    /// How it was understood, in words.
    pub meant: String,
}

/// What a program does not say itself.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Diameter of the filament, if it is given.
    pub filament_diameter_mm: Option<f64>,
    /// Width of beads, if it is given.
    pub width_mm: Option<f64>,
    /// Height of beads, if it is given.
    pub height_mm: Option<f64>,
    /// Millimetres in a unit of the program.
    pub scale: f64,
}
