//! The trimmed and clipped sheets of a range of a part's surfaces, made without those that have no part in them.
//!
//! 1. The spacing of the range is measured to what lies within [`SPACING_REACH`] layer heights: these sheets are needed as they are after clipping.
//! 2. A sheet is clipped by earlier ones that it passes through, as these are after clipping, and by what lies ahead within [`CLIP_REACH`] layer heights, as it is before.
//!    So what is passed through is needed as well, and what that passes through, and so on.
//!
//! What may be near is known [by the levels](ExtendedField::levels_near), before it is made.

use super::error::{LayersError, begin};
use crate::ProgressFn;
use crate::curved::surface::{BorderSmoothing, ExtendedField, Levels, SPACING_REACH, Surface};
use crate::parallel::in_parallel_watched;
use crate::trim::{AllTriangles, CLIP_REACH, Clipped, MOVED, Met, TrimmedSheet, Trimmer, earlier_met, slices};
use nalgebra::Point3;
use std::ops::Range;

/// Coordinates are rounded to less than this, in cells.
const ROUNDING: f64 = 1e-6;

/// What sheets are made of.
#[derive(Clone, Copy)]
pub(super) struct SheetMaker<'a> {
    pub(super) extended: &'a ExtendedField,
    pub(super) levels: &'a Levels,
    /// Height of the layers.
    pub(super) height_mm: f64,
    pub(super) cell_mm: f64,
    pub(super) origin: Point3<f64>,
    pub(super) trimmer: &'a Trimmer,
}

impl SheetMaker<'_> {
    /// The sheets of a range, and what else there is near them; all others are empty. What came of clipping is that of the range.
    pub(super) fn make(
        &self,
        range: Range<usize>,
        progress: ProgressFn,
    ) -> Result<(Vec<TrimmedSheet>, Clipped), LayersError> {
        let count = self.levels.values.len();
        let in_range: Vec<bool> = (0..count).map(|sheet| range.contains(&sheet)).collect();
        let measured = self.near(&in_range, SPACING_REACH);
        let (mut sheets, mut is_made) = (vec![TrimmedSheet::default(); count], vec![false; count]);
        let (mut is_clipped, mut new, mut met) = (measured.clone(), measured.clone(), Met::new());
        let (changed, clipped) = loop {
            // Later sheets clip nothing.
            let last = new.iter().rposition(|&new| new).unwrap_or(0);
            let near = self.near(&new, CLIP_REACH);
            let missing: Vec<usize> = (0..count).filter(|&k| (near[k] && k <= last || new[k]) && !is_made[k]).collect();
            self.add(&missing, &mut sheets, progress)?;
            missing.iter().for_each(|&sheet| is_made[sheet] = true);
            begin("clip", progress)?;
            let surfaces = slices(&sheets);
            let all = AllTriangles::checked(&surfaces)?;
            let asked: Vec<usize> = (0..count).filter(|&sheet| new[sheet]).collect();
            let met_now = earlier_met(&all, &asked, progress)?;
            new = vec![false; count];
            for place in met_now.values().flatten() {
                let earlier = place[0] as usize;
                new[earlier] |= !is_clipped[earlier];
            }
            met.extend(met_now);
            if !new.contains(&true) {
                break self.trimmer.clip_met(&sheets, &all, &met, range, self.height_mm, progress)?;
            }
            is_clipped.iter_mut().zip(&new).for_each(|(is_clipped, new)| *is_clipped |= new);
        };
        changed.into_iter().for_each(|(sheet, left)| sheets[sheet] = left);
        let others = sheets.iter_mut().zip(&measured).filter(|(_, measured)| !**measured);
        others.for_each(|(sheet, _)| *sheet = TrimmedSheet::default());
        Ok((sheets, clipped))
    }

    /// Which sheets may come as near to some of them as so many layer heights.
    fn near(&self, some: &[bool], heights: f64) -> Vec<bool> {
        // Both have been smoothed and thinned since they were in the cubes of their levels.
        let moved = BorderSmoothing::default().reach + MOVED * self.trimmer.min_edge_mm() / self.cell_mm;
        self.extended.levels_near(self.levels, some, heights * self.height_mm / self.cell_mm + 2.0 * moved + ROUNDING)
    }

    /// Makes some sheets, not clipped yet.
    fn add(&self, numbers: &[usize], sheets: &mut [TrimmedSheet], progress: ProgressFn) -> Result<(), LayersError> {
        let &SheetMaker { extended, levels, cell_mm, origin, trimmer, .. } = self;
        begin("contour", progress)?;
        let mut surfaces = extended.contour_levels(levels, numbers, cell_mm, origin, progress)?;
        surfaces.iter_mut().for_each(|surface| surface.smooth_border(cell_mm, BorderSmoothing::default()));
        begin("trim", progress)?;
        let trimmed = |k: usize, watch: ProgressFn| {
            let Surface { points, triangles, .. } = &surfaces[k];
            trimmer.trim(points, triangles, watch)
        };
        let trimmed = in_parallel_watched(numbers.len(), "trim", progress, trimmed).ok_or(LayersError::Cancelled)?;
        for (&number, sheet) in numbers.iter().zip(trimmed) {
            sheets[number] = sheet?;
        }
        Ok(())
    }
}
