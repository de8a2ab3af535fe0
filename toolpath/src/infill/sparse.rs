//! Figures of what is sparse.

/// The sparse part of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SparseFill {
    /// Its area.
    pub area_mm2: f64,
    /// Area by the thickness of the layer.
    pub volume_mm3: f64,
    /// Curves in it.
    pub curves: usize,
    /// Length of the beads in it.
    pub infill_mm: f64,
    /// Their volume: length by width by thickness.
    pub infill_mm3: f64,
}

impl SparseFill {
    pub(crate) fn add(&mut self, other: &SparseFill) {
        self.area_mm2 += other.area_mm2;
        self.volume_mm3 += other.volume_mm3;
        self.curves += other.curves;
        self.infill_mm += other.infill_mm;
        self.infill_mm3 += other.infill_mm3;
    }

    /// Share of the volume that beads fill; 0 where nothing is sparse.
    pub fn density(&self) -> f64 {
        if self.volume_mm3 > 0.0 { self.infill_mm3 / self.volume_mm3 } else { 0.0 }
    }
}
