//! The levels of a part's surfaces, half layers among them, and which surfaces can come near others.
//!
//! A surface lies in the cubes of the lattice that its level crosses. So it is known where it is before it is made, and a few of the surfaces can be made
//! without the others.

use super::contour::{ContourError, Surface, around, contour, each_crossing};
use super::extend::ExtendedField;
use super::marks::Marks;
use crate::ProgressFn;
use nalgebra::Point3;

/// The levels at which surfaces lie, rising.
#[derive(Clone, Debug)]
pub(crate) struct Levels {
    /// In layers of the field.
    pub(crate) values: Vec<f64>,
    /// Whether each is a half layer.
    pub(crate) is_half: Vec<bool>,
}

impl ExtendedField {
    /// Some levels, which rise, and the half layers between them, if the field [has some](super::LayerField::with_half_layers). Half layers without a
    /// triangle are left out.
    ///
    /// # Errors
    /// As [`contour`](contour()).
    pub(crate) fn with_half_layers(
        &self,
        levels: &[f64],
        cell_mm: f64,
        origin: Point3<f64>,
        progress: ProgressFn,
    ) -> Result<Levels, ContourError> {
        let mut all: Vec<(bool, f64)> = levels.iter().map(|&level| (false, level)).collect();
        if self.half_layers().is_some() {
            let between: Vec<f64> = levels.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
            let has_half_layer = self.has_half_layer(&between, cell_mm, origin, progress)?;
            all.extend(between.into_iter().zip(has_half_layer).filter(|(_, has)| *has).map(|(level, _)| (true, level)));
        }
        all.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let (is_half, values) = all.into_iter().unzip();
        Ok(Levels { values, is_half })
    }

    /// The surfaces at the levels with these numbers.
    ///
    /// # Errors
    /// As [`contour`](contour()).
    pub(crate) fn contour_levels(
        &self,
        levels: &Levels,
        numbers: &[usize],
        cell_mm: f64,
        origin: Point3<f64>,
        progress: ProgressFn,
    ) -> Result<Vec<Surface>, ContourError> {
        let values: Vec<f64> = numbers.iter().map(|&number| levels.values[number]).collect();
        let mut surfaces = contour(self, &values, cell_mm, origin, progress)?;
        let halves = surfaces.iter_mut().zip(numbers).filter(|&(_, &number)| levels.is_half[number]);
        halves.for_each(|(surface, _)| self.keep_half_layer(surface, cell_mm, origin));
        Ok(surfaces)
    }

    /// For each level whether its surface can come as near as `reach`, in cells, to one of some surfaces; these are among them.
    pub(crate) fn levels_near(&self, levels: &Levels, some: &[bool], reach: f64) -> Vec<bool> {
        if !some.contains(&false) {
            return some.to_vec();
        }
        let strides = self.lattice.strides();
        let own: Vec<f64> = levels.values.iter().zip(some).filter(|(_, own)| **own).map(|(level, _)| *level).collect();
        let mut marks = Marks::none_of(&self.lattice);
        each_crossing(
            self,
            &own,
            |_| true,
            |crossing, _| around(crossing, strides).iter().for_each(|&cube| marks.mark(cube)),
        );
        // Cubes next to each other are no distance apart. Any step beyond the lattice is as good as one across it.
        let across = self.lattice.dims.into_iter().max().unwrap_or(0);
        let marks = marks.widened((1.0 + reach).min(f64::from(across)) as usize);
        let is_near = |crossing| around(crossing, strides).iter().any(|&cube| marks.has(cube));
        let mut near = some.to_vec();
        each_crossing(self, &levels.values, is_near, |_, level| near[level] = true);
        near
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LayerField, extend};
    use super::*;
    use crate::cells::Cells;
    use proptest::prelude::*;
    use std::ops::ControlFlow;

    const DIMS: [u32; 3] = [9, 3, 11];

    /// Least and greatest corner of each triangle.
    fn boxes(surface: &Surface) -> Vec<[Point3<f64>; 2]> {
        let of = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| surface.points[corner as usize]);
            [a.inf(&b).inf(&c), a.sup(&b).sup(&c)]
        };
        surface.triangles.iter().map(of).collect()
    }

    /// How far two boxes are apart along the axis along which they are farthest.
    fn apart(one: &[Point3<f64>; 2], other: &[Point3<f64>; 2]) -> f64 {
        (0..3).map(|k| (one[0][k] - other[1][k]).max(other[0][k] - one[1][k])).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn surfaces_within_reach_are_known_before_they_are_made(
            rise in prop::array::uniform2(prop::array::uniform3(-0.4..0.8_f64)), wall in 2..8_u32, step in 0.3..2.5_f64, reach in 0.0..4.0_f64,
            is_halved in any::<bool>(), picked in any::<prop::sample::Index>(),
        ) {
            let rows = vec![0x1ff; 33];
            let cells = Cells::new(DIMS, &rows).unwrap();
            let value = |cell: u32| {
                let at = cells.position(cell);
                let [a, b, c] = rise[usize::from(at[0] < wall)];
                (3.0 + a * f64::from(at[0]) + b * f64::from(at[1]) + (c + 0.5) * f64::from(at[2])).max(0.0)
            };
            let field = LayerField::new(&cells, cells.iter().map(value).collect(), 1.0).unwrap();
            let field = extend(&field.with_half_layers(is_halved.then_some(1.2)), &cells);
            let silent = |_| ControlFlow::Continue(());
            let values: Vec<f64> = (0..60).map(|k| (f64::from(k) + 0.5) * step).take_while(|&level| level < field.highest()).collect();
            prop_assume!(!values.is_empty());
            let levels = field.with_half_layers(&values, 1.0, Point3::origin(), &silent).unwrap();
            let all: Vec<usize> = (0..levels.values.len()).collect();
            let surfaces = field.contour_levels(&levels, &all, 1.0, Point3::origin(), &silent).unwrap();
            let boxes: Vec<Vec<_>> = surfaces.iter().map(boxes).collect();
            // Half layers are there if they have a triangle.
            prop_assert!(levels.is_half.iter().zip(&boxes).all(|(is_half, boxes)| !is_half || !boxes.is_empty()));
            let between: Vec<f64> = values.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
            let missing: Vec<f64> = between.into_iter().filter(|level| is_halved && !levels.values.contains(level)).collect();
            let is_half = vec![true; missing.len()];
            let others: Vec<usize> = (0..missing.len()).collect();
            let others = field.contour_levels(&Levels { values: missing, is_half }, &others, 1.0, Point3::origin(), &silent).unwrap();
            prop_assert!(others.iter().all(|surface| surface.triangles.is_empty()));

            let own = picked.index(all.len());
            let some: Vec<bool> = all.iter().map(|&k| k == own).collect();
            let near = field.levels_near(&levels, &some, reach);
            for k in all {
                let is_near = boxes[k].iter().any(|one| boxes[own].iter().any(|other| apart(one, other) <= reach));
                prop_assert!(near[k] || !is_near, "{k} is near {own}");
            }
        }
    }
}
