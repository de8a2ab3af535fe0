//! What comments of a whole file say: diameter of the filament, whether layers are marked, whether directions are.

use super::lines::Lines;
use std::io::BufRead;

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    /// Diameter of the filament, in millimetres.
    pub filament_diameter_mm: Option<f64>,
    /// Whether comments mark layers.
    pub has_layers: bool,
    /// Whether infill is solid, as the settings of the slicer say.
    pub is_solid: bool,
    /// Whether comments have directions of the nozzle.
    pub has_directions: bool,
}

/// Looks through the comments.
///
/// # Errors
/// What cannot be read.
pub fn read(reader: impl BufRead) -> Result<Hints, String> {
    let mut hints = Hints::default();
    let mut lines = Lines::new(reader);
    while let Some(text) = lines.next()? {
        let Some((_, comment)) = text.split_once(';') else { continue };
        let comment = comment.trim();
        hints.has_layers |= layer(comment).is_some();
        hints.has_directions |= comment.starts_with("DIR:");
        let density = comment.strip_prefix("fill_density").or_else(|| comment.strip_prefix("sparse_infill_density"));
        let density = density.and_then(|rest| rest.trim().strip_prefix('=')).map(str::trim);
        hints.is_solid |= density == Some("100%");
        if let Some(value) = comment.strip_prefix("filament_diameter").and_then(|rest| rest.trim().strip_prefix('=')) {
            let first = value.split([',', ';']).next().unwrap_or("").trim().parse::<f64>();
            let first = first.ok().filter(|mm| (0.1..=100.0).contains(mm));
            hints.filament_diameter_mm = hints.filament_diameter_mm.or(first);
        }
    }
    Ok(hints)
}

/// A mark of a layer: the next one, or the one of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerMark {
    /// One more.
    Next,
    /// That of a number.
    Number(i32),
}

/// `LAYER_CHANGE` (PrusaSlicer and its relatives), `LAYER:4` (Cura, ideaMaker), `layer 4, Z = 1.2` (Simplify3D), `CHANGE_LAYER` (Bambu Studio).
pub fn layer(comment: &str) -> Option<LayerMark> {
    if comment == "LAYER_CHANGE" || comment == "CHANGE_LAYER" {
        return Some(LayerMark::Next);
    }
    let number = comment.strip_prefix("LAYER:").or_else(|| {
        let (number, rest) = comment.strip_prefix("layer ")?.split_once(',')?;
        rest.trim_start().starts_with('Z').then_some(number)
    })?;
    number.trim().parse().ok().map(LayerMark::Number)
}
