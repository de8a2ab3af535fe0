//! Numbers that identify what results are of: 64-bit FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo). Not made to withstand forgers.

use super::store::SavedField;
use nalgebra::Point3;

/// A hash in the making.
struct Stamp(u64);

impl Stamp {
    const START: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;

    fn add(&mut self, bits: u64) {
        let byte = |stamp: u64, &byte: &u8| (stamp ^ u64::from(byte)).wrapping_mul(Self::PRIME);
        self.0 = bits.to_le_bytes().iter().fold(self.0, byte);
    }

    fn add_all(&mut self, bits: impl IntoIterator<Item = u64>) {
        bits.into_iter().for_each(|bits| self.add(bits));
    }
}

/// A number that identifies a mesh: any change of a coordinate, a triangle or their order changes it.
///
/// # Example
/// ```
/// use curvlay_layers::{curved::surface::mesh_stamp, nalgebra::Point3};
/// let mut points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
/// let before = mesh_stamp(&points, &[[0, 1, 2]]);
/// points[2].y = 1.0 + f64::EPSILON;
/// assert_ne!(before, mesh_stamp(&points, &[[0, 1, 2]]));
/// ```
pub fn mesh_stamp(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> u64 {
    let mut stamp = Stamp(Stamp::START);
    stamp.add(points.len() as u64);
    stamp.add_all(points.iter().flat_map(|p| p.iter()).map(|c| c.to_bits()));
    stamp.add_all(triangles.iter().flatten().map(|&v| u64::from(v)));
    stamp.0
}

impl SavedField {
    /// A number that identifies the surfaces that are made of the field, before they are: any change of the mesh, the cells, the values, the support or the layer height
    /// changes it. What judged the order does not.
    ///
    /// # Arguments
    /// * `height_mm`: the layer height that is asked for.
    ///
    /// # Cost
    /// `O(n)` for `n` cells of the grid.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::{LayerField, SavedField};
    /// let rows = vec![0b11];
    /// let field = LayerField::new(&Cells::new([2, 1, 1], &rows)?, vec![0.5, 1.5], 1.0)?;
    /// let saved = SavedField { field, rows, cell_mm: 0.8, origin: [0.0; 3].into(), mesh: 7, aids: Default::default() };
    /// let other = SavedField { mesh: 8, ..saved.clone() };
    /// assert_eq!(saved.surfaces_stamp(0.2), saved.clone().surfaces_stamp(0.2));
    /// assert_ne!(saved.surfaces_stamp(0.2), saved.surfaces_stamp(0.3));
    /// assert_ne!(saved.surfaces_stamp(0.2), other.surfaces_stamp(0.2));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn surfaces_stamp(&self, height_mm: f64) -> u64 {
        let SavedField { field, rows, cell_mm, origin, mesh, aids } = self;
        let mut stamp = Stamp(Stamp::START);
        stamp.add_all(field.dims().map(u64::from));
        stamp.add_all(rows.iter().copied());
        // What is not a number is no value, whichever bits it has.
        let value = |value: &f64| if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() };
        stamp.add_all(field.values().iter().map(value));
        let half_layers = field.half_layers().unwrap_or(0.0);
        stamp.add_all(
            [field.layer_cells(), half_layers, *cell_mm, origin.x, origin.y, origin.z, height_mm].map(f64::to_bits),
        );
        for cells in [&aids.support, &aids.contact] {
            stamp.add(cells.len() as u64);
            stamp.add_all(cells.iter().map(|&cell| u64::from(cell)));
        }
        stamp.add(*mesh);
        stamp.0
    }
}
