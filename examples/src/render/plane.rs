//! A plane that cuts a grid.

/// A plane across x or y, between two cells of the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// In front of the cells with this x.
    X(u32),
    /// In front of the cells with this y.
    Y(u32),
}

impl Plane {
    /// The plane through the middle of a grid.
    pub fn middle_x(dims: [u32; 3]) -> Self {
        Plane::X(dims[0] / 2)
    }

    /// The plane through the middle of a grid.
    pub fn middle_y(dims: [u32; 3]) -> Self {
        Plane::Y(dims[1] / 2)
    }

    /// 0 for x, 1 for y.
    pub(super) fn axis(self) -> usize {
        match self {
            Plane::X(_) => 0,
            Plane::Y(_) => 1,
        }
    }

    pub(super) fn index(self) -> u32 {
        match self {
            Plane::X(index) | Plane::Y(index) => index,
        }
    }
}
