//! The rules an order of cells has to keep: who supports whom, and what counts as inside.
//!
//! Dai 2020, Definitions 1 to 3 in section 3.4.1; Boge 2019, Definition 3 and section 6.1.1.
//! Symbols: `N(v)` is [`Neighbours::offsets`], the paper's epsilon is [`Rules::inside_depth_cells`].

use curvlay_hull::Depth;

/// Which cells support a cell ("AM-stable neighbours").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Neighbours {
    /// The 18 cells that share a face or an edge (Boge 2019, Definition 3: distance 1 or the root of 2).
    #[default]
    FaceOrEdge,
    /// Those 18 and the 6 cells two steps away along an axis: Dai 2020, Definition 1 to the letter (1-norm 1
    /// or 2). The outer six do not touch the cell, so such an order may leave gaps.
    OneNorm,
}

impl Neighbours {
    /// The neighbours of the cell `[0, 0, 0]`, in the order of their cell numbers.
    pub fn offsets(self) -> &'static [[i32; 3]] {
        match self {
            Neighbours::FaceOrEdge => &FACE_OR_EDGE,
            Neighbours::OneNorm => &ONE_NORM,
        }
    }
}

/// Face and edge neighbours by rising z, then y, then x.
#[rustfmt::skip]
const FACE_OR_EDGE: [[i32; 3]; 18] = [
    [0, -1, -1], [-1, 0, -1], [0, 0, -1], [1, 0, -1], [0, 1, -1],
    [-1, -1, 0], [0, -1, 0], [1, -1, 0], [-1, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0],
    [0, -1, 1], [-1, 0, 1], [0, 0, 1], [1, 0, 1], [0, 1, 1],
];

/// All offsets of 1-norm 1 or 2 by rising z, then y, then x.
#[rustfmt::skip]
const ONE_NORM: [[i32; 3]; 24] = [
    [0, 0, -2],
    [0, -1, -1], [-1, 0, -1], [0, 0, -1], [1, 0, -1], [0, 1, -1],
    [0, -2, 0], [-1, -1, 0], [0, -1, 0], [1, -1, 0], [-2, 0, 0], [-1, 0, 0],
    [1, 0, 0], [2, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0],
    [0, -1, 1], [-1, 0, 1], [0, 0, 1], [1, 0, 1], [0, 1, 1],
    [0, 0, 2],
];

/// What counts as supported and what as inside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Rules {
    /// Depth below the surface of the hull from which a cell centre counts as inside, in cells; 0 means that a
    /// centre on the surface is inside (Boge's rule). Taken to the nearest 1/1024 of a cell. Default 1.
    pub inside_depth_cells: f64,
    /// Whether a centre at exactly the depth `eps` counts as inside. Default true: Dai's Definition 3 to the letter (`d >= eps`).
    /// Under flat facets cells lie at depths of whole cells, so with a whole `eps` this decides for many of them; with `false`
    /// they can be built.
    pub boundary_is_inside: bool,
    /// Which cells support a cell.
    pub neighbours: Neighbours,
    /// The object is two-dimensional: the grid is one cell deep in y, and each cell stands for a bar along y
    /// that never ends, so hulls are hulls in the plane of x and z. Default false.
    pub flat: bool,
}

impl Default for Rules {
    fn default() -> Self {
        Rules { inside_depth_cells: 1.0, boundary_is_inside: true, neighbours: Neighbours::default(), flat: false }
    }
}

/// Why rules cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RulesError {
    /// The depth is negative, not a number, or more than [`Rules::MAX_INSIDE_DEPTH_CELLS`].
    #[error("the depth inside the hull (eps) is {cells} cells: it must be from 0 to {}", Rules::MAX_INSIDE_DEPTH_CELLS)]
    InsideDepth {
        /// The depth that was asked for.
        cells: f64,
    },
    /// A two-dimensional object in a grid that is more than one cell deep.
    #[error("a flat object must be one cell deep in y, this grid is {ny} deep")]
    NotFlat {
        /// Cells of the grid along y.
        ny: u32,
    },
    /// The mould of the platform lies in another grid.
    #[error("the mould lies in a grid of {mould:?} cells, the part in one of {cells:?}")]
    MouldGrid {
        /// Cells of the grid of the mould along x, y and z.
        mould: [u32; 3],
        /// Cells of the grid of the part.
        cells: [u32; 3],
    },
    /// The part and the mould have cells in common.
    #[error("{cells} cells of the part lie in the mould: take only those of `Platform::outside_mould`")]
    InMould {
        /// Cells that are in both.
        cells: usize,
    },
}

impl Rules {
    /// Largest depth that is accepted, in cells: beyond it nothing is protected from a collision any more, and
    /// the squares that decide ties no longer fit 128 bits.
    pub const MAX_INSIDE_DEPTH_CELLS: f64 = 16.0;

    /// The depth in units of 1/1024 of a cell, once it is known to be sound.
    ///
    /// # Errors
    /// [`RulesError::InsideDepth`] for a depth that is negative, not finite or too large.
    pub fn inside_depth_in_1024ths(&self) -> Result<u32, RulesError> {
        if !(0.0..=Self::MAX_INSIDE_DEPTH_CELLS).contains(&self.inside_depth_cells) {
            return Err(RulesError::InsideDepth { cells: self.inside_depth_cells });
        }
        Ok((self.inside_depth_cells * 1024.0).round() as u32)
    }

    /// From where on a centre is inside, in lattice units: two to a cell.
    pub(crate) fn depth(&self) -> Result<Depth, RulesError> {
        let units = 2.0 * f64::from(self.inside_depth_in_1024ths()?) / 1024.0;
        let depth = if self.boundary_is_inside { Depth::new(units) } else { Depth::beyond(units) };
        depth.map_err(|_| RulesError::InsideDepth { cells: self.inside_depth_cells })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;
    use crate::curved::buildable::platform::Platform;

    #[test]
    fn offsets_are_those_of_the_definitions_in_order() {
        for (rule, far) in [(Neighbours::FaceOrEdge, 1), (Neighbours::OneNorm, 2)] {
            let mut expected = Vec::new();
            for z in -2i32..=2 {
                for y in -2i32..=2 {
                    for x in -2i32..=2 {
                        let norm = x.abs() + y.abs() + z.abs();
                        let reach = x.abs().max(y.abs()).max(z.abs());
                        if (1..=2).contains(&norm) && reach <= far {
                            expected.push([x, y, z]);
                        }
                    }
                }
            }
            assert_eq!(rule.offsets(), expected);
        }
    }

    #[test]
    fn unsound_rules_are_refused() {
        for eps in [-0.1, f64::NAN, f64::INFINITY, 16.1] {
            let rules = Rules { inside_depth_cells: eps, ..Rules::default() };
            assert!(matches!(rules.inside_depth_in_1024ths(), Err(RulesError::InsideDepth { .. })), "{eps}");
        }
        let flat = Rules { flat: true, ..Rules::default() };
        let platform = Platform::segment(0.0, 3.0).unwrap();
        let check = |ny: u32| flat.check(&Cells::new([3, ny, 3], &vec![0; 3 * ny as usize]).unwrap(), &platform);
        assert_eq!(check(2), Err(RulesError::NotFlat { ny: 2 }));
        assert_eq!(check(1), Ok(()));
        assert_eq!(Rules { inside_depth_cells: 0.5, ..flat }.inside_depth_in_1024ths(), Ok(512));
    }
}
