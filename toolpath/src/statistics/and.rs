//! Figures of two surfaces that have nothing in common, as those of one.

use super::figures::{Gap, PathStatistics};

impl PathStatistics {
    /// Of a surface without area: nothing is left to fill.
    pub(crate) fn of_no_area() -> PathStatistics {
        PathStatistics { filled_fraction: 1.0, ..PathStatistics::default() }
    }

    /// The figures of both: sums, shares by area, and the larger of what is largest. Ways from the curves of one to those of the other are not
    /// counted.
    pub(crate) fn and(&self, other: &PathStatistics) -> PathStatistics {
        let mean = |[a, b]: [f64; 2], [of_a, of_b]: [f64; 2], otherwise: f64| {
            if of_a + of_b > 0.0 { (a * of_a + b * of_b) / (of_a + of_b) } else { otherwise }
        };
        let areas = [self.area_mm2, other.area_mm2];
        let by_area = |of: fn(&PathStatistics) -> f64| mean([of(self), of(other)], areas, 0.0);
        let fillable = [self, other].map(|s| s.area_mm2 * (1.0 - s.unfillable_fraction));
        let largest = |a: Gap, b: Gap| if b.radius_mm > a.radius_mm { b } else { a };
        PathStatistics {
            area_mm2: self.area_mm2 + other.area_mm2,
            covered_fraction: by_area(|s| s.covered_fraction),
            overlap_fraction: by_area(|s| s.overlap_fraction),
            spill_fraction: by_area(|s| s.spill_fraction),
            unfillable_fraction: by_area(|s| s.unfillable_fraction),
            filled_fraction: mean([self.filled_fraction, other.filled_fraction], fillable, 1.0),
            largest_gap: match (self.largest_gap, other.largest_gap) {
                (Some(a), Some(b)) => Some(largest(a, b)),
                (a, b) => a.or(b),
            },
            curves: self.curves + other.curves,
            jumps: self.jumps + other.jumps,
            jump_mm: self.jump_mm + other.jump_mm,
            path_mm: self.path_mm + other.path_mm,
            bead_area_mm2: self.bead_area_mm2 + other.bead_area_mm2,
            in_width_range: mean(
                [self.in_width_range, other.in_width_range],
                [self.bead_area_mm2, other.bead_area_mm2],
                0.0,
            ),
            sharp_turns: self.sharp_turns + other.sharp_turns,
            self_crossings: self.self_crossings + other.self_crossings,
            entry_exit_mm: self.entry_exit_mm.max(other.entry_exit_mm),
            off_surface_mm: self.off_surface_mm + other.off_surface_mm,
            step_mm: self.step_mm.max(other.step_mm),
            samples: self.samples + other.samples,
            each: self.each.iter().chain(&other.each).copied().collect(),
        }
    }
}
