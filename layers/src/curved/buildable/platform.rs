//! What the part stands on.
//!
//! Dai 2020, section 3.4.1 (the platform `T` counts into every hull); Boge 2019, section 6.2.3 (its size decides
//! which cells are missed) and section 6.4 (a platform that stands free).

use super::mould::Mould;
use crate::cells::{Cells, set_bits};
use curvlay_hull::convex_polygon;
use std::f64::consts::PI;

/// A convex platform, in lattice coordinates (half cells, see the [module](crate::curved)), and the mould on it, if there is one.
///
/// A *mould* is what is there before the part: a block with a curved top (Dai 2020, section 5.3.2), or a part that exists already. It is a set of cells
/// in the grid of the part, none of them of the part, and counts as built before the first layer: hulls hold the centres of
/// its cells, it supports its neighbours, and the nozzle must not meet it. The first layer is what lies on the platform or has a common face
/// with the mould, but for cells that lie inside the hull of platform and mould.
#[derive(Clone, Debug, PartialEq)]
pub struct Platform {
    corners: Vec<[i32; 2]>,
    top: i32,
    reaches_down: bool,
    pub(crate) mould: Option<Mould>,
}

/// Why a platform cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlatformError {
    /// Fewer than three corners are left on the lattice: the platform has no area.
    #[error("the platform has no area on the lattice")]
    NoArea,
    /// A coordinate is not a number, or not below 2^15 half cells.
    #[error("an invalid platform coordinate of {value} cells: at most {} cells from the corner of the grid", Platform::REACH / 2)]
    OutOfReach {
        /// The coordinate, in cells.
        value: f64,
    },
    /// The mould has no cell.
    #[error("the mould holds no centre of a cell: place it in the grid of the part, and take cells smaller than it")]
    EmptyMould,
    /// The mould reaches beyond the grid.
    #[error(
        "the mould reaches from {low:?} to {high:?} cells, beyond a grid of {dims:?}: take a grid that holds it too"
    )]
    MouldBeyondGrid {
        /// Lower corner of the box around the mould, in cells.
        low: [f64; 3],
        /// Its upper corner.
        high: [f64; 3],
        /// Cells of the grid.
        dims: [u32; 3],
    },
    /// The mesh of the mould is damaged.
    #[error("the mould: {0}")]
    MouldMesh(crate::trim::TrimError),
}

/// Corners of the polygon that stands for a disc: its edges stay within 1/800 of the radius from the circle
/// (0.08 mm on the default platform, a tenth of a usual cell); more corners only make every hull larger.
const DISC_CORNERS: usize = 64;

impl Platform {
    /// Largest lattice coordinate of a corner, where hulls are exact.
    pub const REACH: i32 = (1 << 15) - 1;

    /// The convex hull of `points`, given in cells and rounded to half cells, with its top on the plate `z = 0`.
    /// It reaches down without end: the hull of it and a part has no underside.
    ///
    /// # Errors
    /// [`PlatformError`] for points out of reach, or without area.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::Platform;
    /// let square = Platform::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [2.0, 2.0]])?;
    /// assert_eq!(square.corners(), [[0, 0], [8, 0], [8, 8], [0, 8]]);
    /// # Ok::<(), curvlay_layers::curved::PlatformError>(())
    /// ```
    pub fn polygon(points: &[[f64; 2]]) -> Result<Self, PlatformError> {
        let to_lattice = |value: f64| {
            let lattice = (2.0 * value).round();
            if lattice.abs() <= f64::from(Self::REACH) {
                Ok(lattice as i32)
            } else {
                Err(PlatformError::OutOfReach { value })
            }
        };
        let lattice =
            points.iter().map(|&[x, y]| Ok([to_lattice(x)?, to_lattice(y)?])).collect::<Result<Vec<_>, _>>()?;
        match convex_polygon(&lattice) {
            corners if corners.len() < 3 => Err(PlatformError::NoArea),
            corners => Ok(Platform { corners, top: 0, reaches_down: true, mould: None }),
        }
    }

    /// A disc (a polygon of 64 corners on the circle), given in cells.
    ///
    /// # Errors
    /// As [`Platform::polygon`].
    pub fn disc(centre: [f64; 2], radius: f64) -> Result<Self, PlatformError> {
        let corner = |k: usize| {
            let angle = 2.0 * PI * k as f64 / DISC_CORNERS as f64;
            [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
        };
        Self::polygon(&(0..DISC_CORNERS).map(corner).collect::<Vec<_>>())
    }

    /// A disc around the middle of the part's projection, of the given radius in cells, or of the least radius
    /// that covers the projection if that is larger.
    ///
    /// # Errors
    /// As [`Platform::polygon`].
    pub fn under(cells: &Cells, radius: f64) -> Result<Self, PlatformError> {
        let columns = columns(cells);
        let bounds = |axis: usize| {
            let low = columns.iter().map(|column| column[axis]).min().unwrap_or(0);
            let high = columns.iter().map(|column| column[axis] + 1).max().unwrap_or(cells.dims()[axis]);
            [f64::from(low), f64::from(high)]
        };
        let centre = [0, 1].map(|axis| bounds(axis).iter().sum::<f64>() / 2.0);
        let reach = |column: &[u32; 2], axis: usize| (f64::from(column[axis]) + 0.5 - centre[axis]).abs() + 0.5;
        let farthest = columns.iter().map(|column| reach(column, 0).hypot(reach(column, 1))).fold(0.0, f64::max);
        // A polygon on a circle comes as near as cos(pi / n) of the radius; half a cell more makes up for rounding.
        let covering = farthest / (PI / DISC_CORNERS as f64).cos() + 0.5;
        Self::disc(centre, radius.max(covering))
    }

    /// For a flat object (see [`Rules::flat`](crate::curved::Rules::flat)): from `x0` to `x1`, in cells.
    ///
    /// # Errors
    /// As [`Platform::polygon`].
    pub fn segment(x0: f64, x1: f64) -> Result<Self, PlatformError> {
        Self::polygon(&[[x0, 0.0], [x1, 0.0], [x1, 1.0], [x0, 1.0]])
    }

    /// The same platform as a thin plate that stands free with its face `top` half cells above the plane `z = 0`
    /// (negative: below). Nothing reaches down from it, so the underside of the hull counts like any other face.
    ///
    /// # Errors
    /// [`PlatformError::OutOfReach`] for a height that is not below 2^15.
    pub fn elevated(self, top: i32) -> Result<Self, PlatformError> {
        if top.unsigned_abs() > Self::REACH.unsigned_abs() {
            return Err(PlatformError::OutOfReach { value: f64::from(top) / 2.0 });
        }
        Ok(Platform { top, reaches_down: false, ..self })
    }

    pub(crate) fn with_mould(self, mould: Mould) -> Self {
        Platform { mould: Some(mould), ..self }
    }

    /// Corners counter-clockwise, in lattice coordinates.
    pub fn corners(&self) -> &[[i32; 2]] {
        &self.corners
    }

    /// Lattice height of the face that the part stands on.
    pub fn top(&self) -> i32 {
        self.top
    }

    /// Whether the platform reaches down without end (else it is a thin plate).
    pub fn reaches_down(&self) -> bool {
        self.reaches_down
    }

    /// Whether a cell of the lowest level whose centre is `[x, y]` stands on the platform: the centre lies over it
    /// or over its edge. For a flat object only `x` counts.
    pub fn carries(&self, [x, y]: [i32; 2], flat: bool) -> bool {
        let mut edges = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        if flat {
            let xs = self.corners.iter().map(|corner| corner[0]);
            return xs.clone().min().is_some_and(|low| low <= x) && xs.max().is_some_and(|high| x <= high);
        }
        edges.all(|(a, b)| {
            let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
            (bx - ax) * (i64::from(y) - ay) >= (by - ay) * (i64::from(x) - ax)
        })
    }
}

/// The projection of the cells along z.
fn columns(cells: &Cells) -> Vec<[u32; 2]> {
    let (words, [_, ny, _]) = (cells.words_per_row(), cells.dims());
    let mut shadow = vec![0; words * ny as usize];
    for level in cells.rows().chunks_exact(shadow.len()) {
        shadow.iter_mut().zip(level).for_each(|(seen, word)| *seen |= word);
    }
    let of_word = |(at, &word): (usize, &u64)| {
        let (x, y) = ((at % words) as u32 * 64, (at / words) as u32);
        set_bits(word).map(move |bit| [x + bit, y])
    };
    shadow.iter().enumerate().flat_map(of_word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_has_its_corners_on_the_circle() {
        let disc = Platform::disc([10.0, 20.0], 80.0).unwrap();
        assert!((60..=DISC_CORNERS).contains(&disc.corners().len()), "rounding costs few corners");
        for &[x, y] in disc.corners() {
            let radius = (f64::from(x) / 2.0 - 10.0).hypot(f64::from(y) / 2.0 - 20.0);
            assert!((radius - 80.0).abs() < 0.36, "{radius}"); // half the diagonal of a half cell
        }
    }

    #[test]
    fn the_default_disc_grows_to_cover_the_part() {
        let rows = vec![u64::MAX; 40 * 2];
        let cells = Cells::new([64, 40, 2], &rows).unwrap();
        let small = Platform::under(&cells, 5.0).unwrap();
        for [x, y] in [[0, 0], [128, 0], [128, 80], [0, 80]] {
            assert!(small.carries([x, y], false));
        }
        let large = Platform::under(&cells, 100.0).unwrap();
        assert_eq!(large, Platform::disc([32.0, 20.0], 100.0).unwrap());
    }

    #[test]
    fn the_edge_carries_and_beyond_does_not() {
        let square = Platform::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]).unwrap();
        assert!(square.carries([8, 3], false) && square.carries([8, 8], false) && square.carries([1, 1], false));
        assert!(!square.carries([9, 3], false) && !square.carries([3, -1], false));
        assert!(square.carries([8, 99], true) && !square.carries([9, 1], true));
    }

    #[test]
    fn unsound_platforms_are_refused() {
        assert_eq!(Platform::polygon(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), Err(PlatformError::NoArea));
        assert!(matches!(Platform::disc([0.0, 0.0], f64::NAN), Err(PlatformError::OutOfReach { .. })));
        assert_eq!(Platform::segment(0.0, 20_000.0), Err(PlatformError::OutOfReach { value: 20_000.0 }));
        let plate = Platform::segment(0.0, 3.0).unwrap();
        assert!(plate.clone().elevated(i32::MIN).is_err());
        assert!(!plate.elevated(-1).unwrap().reaches_down());
    }
}
