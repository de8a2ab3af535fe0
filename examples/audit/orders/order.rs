//! An order of cells, as all readers make it.

use nalgebra::{Point3, UnitVector3};

/// How files are meant that do not say all of it.
#[derive(Clone, Copy, Debug)]
pub struct OrderOptions {
    /// Edge of a cell in millimetres, if it is given.
    pub cell_mm: Option<f64>,
    /// The number of the first layer: 1, or 0 in files that count from there.
    pub first_layer: u32,
    /// Thickness of a layer in the units of a growth field, if it is given.
    pub field_step: Option<f64>,
    /// Cells that a grid may have at most.
    pub max_cells: u64,
}

/// A line of an order: a cell in a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its place in the grid.
    pub cell: [u32; 3],
    /// The layer from 1; 0 for a cell of the solid that is not built.
    pub layer: u32,
    /// From the tip into the nozzle that prints it, where the file says it.
    pub direction: Option<UnitVector3<f64>>,
}

/// An order of cells as a file has it: a cell may stand in it several times.
#[derive(Clone, Debug, PartialEq)]
pub struct CellOrder {
    /// Cells along x, y and z.
    pub dims: [u32; 3],
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// The low corner of the grid, in millimetres.
    pub origin: Point3<f64>,
    /// All entries in the order of the file.
    pub entries: Vec<Entry>,
    /// How the file was understood, in words.
    pub meant: String,
}

/// Larger layer numbers are a slip: a layer has a cell at least.
pub const MAX_LAYER: u32 = 100_000_000;

/// Why a file is not an order: what is wrong, and the line from 1 if it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderFault {
    /// The line, from 1; 0 for the whole file.
    pub line: usize,
    /// What is wrong.
    pub what: String,
}

impl OrderFault {
    pub fn at(line: usize, what: impl Into<String>) -> Self {
        OrderFault { line, what: what.into() }
    }
}

/// Dimensions that a grid may have, before anything of its size is allocated.
pub fn checked_dims(dims: [u64; 3], options: &OrderOptions, line: usize) -> Result<[u32; 3], OrderFault> {
    let max_side = u64::from(curvlay_layers::cells::Cells::MAX_SIDE);
    let count = dims.iter().try_fold(1u64, |count, &side| count.checked_mul(side));
    let [nx, ny, nz] = dims;
    match count {
        Some(0) => Err(OrderFault::at(line, format!("a grid of {nx} x {ny} x {nz} cells has no cell"))),
        Some(count) if count <= options.max_cells && dims.iter().all(|&side| side <= max_side) => {
            Ok(dims.map(|side| side as u32))
        }
        _ => Err(OrderFault::at(
            line,
            format!(
                "a grid of {nx} x {ny} x {nz} cells is too large (at most {max_side} along an axis and --max-cells {}): are the numbers millimetres, \
                 and --cell their step?",
                options.max_cells
            ),
        )),
    }
}

/// A layer number of a file, by the rule of the options: 0 for a cell that is not built.
pub fn layer_of(value: f64, options: &OrderOptions) -> Option<u32> {
    let from_one = value - f64::from(options.first_layer) + 1.0;
    let is_whole = (from_one - from_one.round()).abs() <= 0.0;
    if !is_whole || from_one > f64::from(MAX_LAYER) {
        return None;
    }
    Some(if from_one < 1.0 { 0 } else { from_one as u32 })
}

/// Layers by rising values of a growth field, each `step` thick: layer N has values in (N - 1, N] steps; a value of 0 is in the first.
pub fn layer_by_value(value: f64, step: f64) -> Option<u32> {
    let layer = (value / step - ROUNDING).ceil().max(1.0);
    (layer <= f64::from(MAX_LAYER)).then_some(layer as u32)
}

/// Values of a field that are above a border by this share of a step are on it.
const ROUNDING: f64 = 1e-9;
