//! A platform with a mould on it: the cells of the mould, or those inside of its mesh.
//!
//! Dai 2020, section 5.3.2.

use super::mould::Mould;
use super::platform::{Platform, PlatformError};
use super::rules::{Rules, RulesError};
use crate::cells::{CellSet, Cells, FACES};
use crate::parallel::in_parallel;
use crate::trim::Inside;
use curvlay_hull::convex_polygon;
use nalgebra::Point3;

/// Cells that a thread looks at at a time: some hundred microseconds.
const AT_A_TIME: usize = 64;

/// Where a mesh is nearest to the centres of the cells beside those of the mould, by rising number. These are no more than a cell away from it.
fn nearest(mould: &Cells, mesh: &Inside) -> Vec<(u32, Point3<f64>)> {
    let mut beside = CellSet::none(mould);
    for at in mould.iter().map(|cell| mould.position(cell)) {
        let next = FACES.map(|step| [0, 1, 2].map(|axis| at[axis].wrapping_add_signed(step[axis])));
        let is_beside = |at: &[u32; 3]| (0..3).all(|axis| at[axis] < mould.dims()[axis]) && !mould.contains(*at);
        next.into_iter().filter(is_beside).for_each(|at| _ = beside.insert(mould.id(at)));
    }
    let cells: Vec<u32> = beside.iter().collect();
    let points = in_parallel(cells.len(), AT_A_TIME, |k| mesh.nearest(&mould.centre(cells[k])));
    cells.into_iter().zip(points).collect()
}

/// The centres of cells that can be corners of their hull.
fn corners(mould: &Cells) -> Vec<[i32; 3]> {
    let set = CellSet::of(mould);
    let mut corners = Vec::new();
    for level in 0..set.levels() {
        let centre = |cell: u32| mould.position(cell).map(|k| 2 * k as i32 + 1);
        let points: Vec<[i32; 2]> = set.level(level).map(centre).map(|[x, y, _]| [x, y]).collect();
        corners.extend(convex_polygon(&points).into_iter().map(|[x, y]| [x, y, 2 * level as i32 + 1]));
    }
    corners
}

impl Platform {
    /// The platform with a mould on it, or with a part that exists already: `mould` holds its cells, in the grid of the part.
    ///
    /// # Errors
    /// [`PlatformError::EmptyMould`] without a cell.
    ///
    /// # Cost
    /// A pass over the cells of the mould.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::{Platform, Rules, Strategy, audit};
    /// use std::ops::ControlFlow::Continue;
    /// // A step of two levels below a part of two cells in each column.
    /// let mould = Cells::new([4, 1, 4], &[0b1111, 0b1100, 0, 0])?;
    /// let part = Cells::new([4, 1, 4], &[0, 0b0011, 0b1111, 0b1100])?;
    /// let platform = Platform::under(&part, 10.0)?.on_mould(&mould)?;
    /// let (rules, go) = (Rules::default(), |_| Continue(()));
    /// let growth = Strategy::Incremental.grow(&part, &platform, &rules, &go)?;
    /// assert_eq!(growth.order.layer(0), [4, 5, 10, 11]); // along the step
    /// assert!(audit(&part, &platform, &rules, &growth.order, &[], &go)?.is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on_mould(self, mould: &Cells) -> Result<Platform, PlatformError> {
        if mould.count() == 0 {
            return Err(PlatformError::EmptyMould);
        }
        let (dims, rows) = (mould.dims(), mould.rows().to_vec());
        Ok(self.with_mould(Mould { dims, rows, corners: corners(mould), nearest: Vec::new() }))
    }

    /// The platform with a mould on it that is a triangle mesh: the cells with their centre inside the mesh. Orders by distance begin at the mesh itself, not at
    /// these cells.
    ///
    /// # Arguments
    /// * `dims`: cells of the grid of the part. It must hold the mould, too, but for what is below the platform: what
    ///   lies outside of the grid would be ignored.
    /// * `cell_mm`, `origin`: edge of a cell and lower corner of the grid, in the unit of the points.
    /// * `points`, `triangles`: the mesh, normals outwards. Holes are closed by its winding number.
    ///
    /// # Errors
    /// [`PlatformError`] for a damaged mesh, one beyond the grid, or one that holds no cell.
    ///
    /// # Cost
    /// Some microseconds for each cell of the box around the mesh.
    pub fn on_mould_mesh(
        self,
        dims: [u32; 3],
        cell_mm: f64,
        origin: Point3<f64>,
        points: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) -> Result<Platform, PlatformError> {
        let in_cells: Vec<Point3<f64>> = points.iter().map(|p| Point3::from((p - origin) / cell_mm)).collect();
        let mesh = Inside::new(&in_cells, triangles).map_err(PlatformError::MouldMesh)?;
        let rows = mesh.cells(dims);
        let used = || triangles.iter().flatten().map(|&corner| in_cells[corner as usize]);
        let bound = |axis: usize, of: fn(f64, f64) -> f64, start: f64| used().map(|p| p[axis]).fold(start, of);
        let low = [0, 1, 2].map(|axis| bound(axis, f64::min, f64::INFINITY));
        let high = [0, 1, 2].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
        // Less than half a cell beyond the grid is no centre of a cell.
        let is_beyond = |axis: usize| low[axis] < -0.5 && axis < 2 || high[axis] > f64::from(dims[axis]) + 0.5;
        if (0..3).any(is_beyond) {
            return Err(PlatformError::MouldBeyondGrid { low, high, dims });
        }
        let cells = Cells::new(dims, &rows).map_err(|_| PlatformError::EmptyMould)?;
        let mut platform = self.on_mould(&cells)?;
        platform.mould.iter_mut().for_each(|mould| mould.nearest = nearest(&cells, &mesh));
        Ok(platform)
    }

    /// The cells of the mould, if there is one.
    pub fn mould(&self) -> Option<Cells<'_>> {
        self.mould.as_ref().map(Mould::cells)
    }

    /// `cells` without those of the mould, as bits like those of [`Cells::rows`]: what can be the part.
    ///
    /// # Errors
    /// [`RulesError::MouldGrid`] if the mould lies in another grid.
    pub fn outside_mould(&self, cells: &Cells) -> Result<Vec<u64>, RulesError> {
        let mut outside = CellSet::of(cells);
        if let Some(mould) = self.mould_in(cells)? {
            outside.subtract(&CellSet::of(&mould));
        }
        Ok(outside.rows().flatten().copied().collect())
    }

    /// The mould, if there is one, in the grid of `cells`.
    fn mould_in(&self, cells: &Cells) -> Result<Option<Cells<'_>>, RulesError> {
        match self.mould() {
            Some(mould) if mould.dims() != cells.dims() => {
                Err(RulesError::MouldGrid { mould: mould.dims(), cells: cells.dims() })
            }
            mould => Ok(mould),
        }
    }

    /// That the mould lies in the grid of the cells and holds none of them.
    fn check(&self, cells: &Cells) -> Result<(), RulesError> {
        let common = |mould: Cells| -> usize {
            mould.rows().iter().zip(cells.rows()).map(|(a, b)| (a & b).count_ones() as usize).sum()
        };
        match self.mould_in(cells)?.map_or(0, common) {
            0 => Ok(()),
            cells => Err(RulesError::InMould { cells }),
        }
    }
}

impl Rules {
    /// Checks the rules against the size of a grid, and the platform against the cells.
    pub(crate) fn check(&self, cells: &Cells, platform: &Platform) -> Result<(), RulesError> {
        self.inside_depth_in_1024ths()?;
        match cells.dims() {
            [_, ny, _] if self.flat && ny != 1 => Err(RulesError::NotFlat { ny }),
            _ => platform.check(cells),
        }
    }
}
