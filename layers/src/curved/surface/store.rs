//! Fields in files, so that work can go on from them later.
//!
//! Text, one thing a line, numbers as they round-trip:
//! ```text
//! curvlay field 1
//! mesh 0123456789abcdef      the stamp of the mesh, in hexadecimal digits
//! grid 40 30 50              cells along x, y and z
//! cell_mm 0.8
//! origin_mm -16 -12 0        the low corner of the grid
//! layer_cells 1              how thick a layer is, in cells; then the steps of the order to a layer, if more than one
//! half_layers 1.45           only with half layers: how many layer heights apart layers are that have one between them
//! cells 2                    so many lines follow: a cell of the solid each, by rising number
//! 17 0.5                     its value in layers
//! 18 -                       or none: it is missed
//! support 1                  only with support: so many lines follow, a cell each that is support, by rising number
//! 18
//! gap 1                      only with gaps between support and part: likewise
//! 19
//! contact 1                  only where support touches the part: likewise the cells of the part that hold both
//! 17
//! nozzle 1 0.7853981633974483 8 20 1.5707963267948966 0.5    only with cells judged by the nozzle: tip flat (mm), half angle (rad), height of the
//!                            cone (mm), block (mm), tilt limit (rad), margin (cells)
//! directions 1               so many lines follow: a cell, and the direction from the tip to the block
//! 17 0 0 1
//! end
//! ```

use super::field::{FieldError, LayerField};
use crate::cells::{Cells, CellsError};
use crate::curved::{Growth, GrowthStatistics, MissedCell, MissedReason, NozzleCell, NozzleRule, NozzleRuleError};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::io::{self, BufRead, Read, Write};

/// Cells of the grid for each cell of the solid, and on top of that, beyond which a file is not believed: memory must
/// follow what a file holds, not what it says. A hollow sphere a thousand cells wide has 170 for each.
const MAX_GRID: [u64; 2] = [512, 1 << 22];

/// Height of a field in cells for each cell of the solid, and on top of that, beyond which a file is not believed. A layer has a
/// cell at least, and next to none is thicker than two cells.
const MAX_HEIGHT: [f64; 2] = [4.0, 64.0];

/// Steps of an order to a layer at most: with more a step is thinner than rounding.
const MAX_STEPS: u32 = 1 << 16;

/// Bytes of a line at most. A number is written with as many digits as it has, which are some hundred for the least ones.
const MAX_BYTES: u64 = 4096;

/// A field with all that is needed to go on from it.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedField {
    /// The field.
    pub field: LayerField,
    /// The cells of the solid, missed ones included, as [`Cells`] takes them.
    pub rows: Vec<u64>,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// Low corner of the grid in millimetres.
    pub origin: Point3<f64>,
    /// The [stamp](super::mesh_stamp) of the mesh that the cells were made of.
    pub mesh: u64,
    /// What the order needs beyond the hull rule.
    pub aids: PrintAids,
}

/// What an order needs beyond the hull rule: support, and cells that are judged by the nozzle. None by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrintAids {
    /// The cells that are support, by rising number. They are among those of the field.
    pub support: Vec<u32>,
    /// The cells between support and part that stay empty, by rising number. They are among those of the field, too.
    pub gap: Vec<u32>,
    /// The cells of the part that hold support beside its material, by rising number. They are among those of the field, too.
    pub contact: Vec<u32>,
    /// The nozzle.
    pub rule: NozzleRule,
    /// Cells judged by it, by rising number.
    pub nozzle: Vec<NozzleCell>,
}

/// Why a field could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadFieldError {
    /// The source failed.
    #[error("line {line}: {source}")]
    Io {
        /// The line, from 1.
        line: usize,
        /// What it said.
        source: io::Error,
    },
    /// A line is not what belongs there.
    #[error("line {line}: {expected} expected, found {found:?}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// What belongs there.
        expected: &'static str,
        /// The start of what is there.
        found: String,
    },
    /// The cells do not rise, or lie outside the grid.
    #[error(
        "line {line}: cell {cell} does not come after the one before, or is not built, or lies outside the grid of {grid} cells"
    )]
    Cell {
        /// The line, from 1.
        line: usize,
        /// The cell.
        cell: u32,
        /// Cells of the grid.
        grid: u64,
    },
    /// The grid is far larger than the part in it.
    #[error("a grid of {grid} cells for {cells} cells of the part: the sizes in the file cannot be right")]
    Sparse {
        /// Cells of the grid.
        grid: u64,
        /// Cells of the solid.
        cells: usize,
    },
    /// The grid takes more memory than is allowed.
    #[error("a grid of {grid} cells, more than the {limit} allowed: raise the limit, or grow with larger cells")]
    GridTooLarge {
        /// Cells of the grid.
        grid: u64,
        /// What is allowed.
        limit: u64,
    },
    /// The field is higher than its cells reach.
    #[error("a value of {highest} layers of {layer_cells} cells each: no part of {cells} cells is as high")]
    TooHigh {
        /// The highest value, in layers.
        highest: f64,
        /// How thick a layer is, in cells.
        layer_cells: f64,
        /// Cells of the solid.
        cells: usize,
    },
    /// The grid is no grid.
    #[error(transparent)]
    Cells(#[from] CellsError),
    /// The values are no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The nozzle is invalid.
    #[error(transparent)]
    Nozzle(#[from] NozzleRuleError),
}

/// The mesh is not the one that a field was made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the mesh has changed since the field was saved: its stamp is {now:016x}, that of the field {saved:016x}")]
pub struct OtherMesh {
    /// The stamp in the file.
    pub saved: u64,
    /// The stamp of the mesh.
    pub now: u64,
}

/// The cells are not those that a field was made for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OtherCells {
    /// Other cells, or another grid.
    #[error("the saved field is of other cells than the mesh gives: grow it anew")]
    Cells,
    /// The grid is elsewhere.
    #[error(
        "the saved field has origin_mm {} {} {}, the cells of the mesh {} {} {}: grow it anew",
        saved.x, saved.y, saved.z, now.x, now.y, now.z
    )]
    Origin {
        /// The low corner in the file.
        saved: Point3<f64>,
        /// That of the cells.
        now: Point3<f64>,
    },
}

impl SavedField {
    /// Cells of the grid, empty ones included, that [`SavedField::read`] allows: a gigabyte of values. A part of ten million cells
    /// in a grid of a tenth of that fill is just within.
    pub const MAX_GRID: u64 = 1 << 27;

    /// The cells of the solid.
    ///
    /// # Errors
    /// [`CellsError`] if `rows` have been changed so that they do not fit the field.
    pub fn cells(&self) -> Result<Cells<'_>, CellsError> {
        Cells::new(self.field.dims(), &self.rows)
    }

    /// The order that the field stands for. Cells without a value are missed; why, the file does not say.
    ///
    /// # Errors
    /// [`CellsError`] if `rows` have been changed so that they do not fit the field.
    pub fn growth(&self) -> Result<Growth, CellsError> {
        let cells = self.cells()?;
        let without = cells.iter().filter(|&cell| self.field.value(cell).is_none());
        let missed = without.map(|cell| MissedCell { cell, reason: MissedReason::SupportMissed }).collect();
        let nozzle = self.aids.nozzle.clone();
        Ok(Growth { order: self.field.rounded(), missed, statistics: GrowthStatistics::default(), nozzle })
    }

    /// Whether the field was made for the mesh with this [stamp](super::mesh_stamp).
    ///
    /// # Errors
    /// [`OtherMesh`] if not.
    pub fn check_mesh(&self, now: u64) -> Result<(), OtherMesh> {
        if self.mesh == now { Ok(()) } else { Err(OtherMesh { saved: self.mesh, now }) }
    }

    /// Whether the field was made for these cells, its support aside, at this low corner in millimetres.
    ///
    /// # Errors
    /// [`OtherCells`] if not.
    pub fn check_cells(&self, cells: &Cells, origin: Point3<f64>) -> Result<(), OtherCells> {
        if self.field.dims() != cells.dims() || self.rows.len() != cells.rows().len() {
            return Err(OtherCells::Cells);
        }
        let mut of_part = self.rows.clone();
        let words = cells.words_per_row();
        for &cell in self.aids.support.iter().chain(&self.aids.gap) {
            let (row, x) = ((cell / cells.dims()[0]) as usize, cell % cells.dims()[0]);
            let word = of_part.get_mut(row * words + x as usize / 64).ok_or(OtherCells::Cells)?;
            *word &= !(1 << (x % 64));
        }
        if of_part != cells.rows() {
            return Err(OtherCells::Cells);
        }
        if self.origin == origin { Ok(()) } else { Err(OtherCells::Origin { saved: self.origin, now: origin }) }
    }

    /// Writes the field.
    ///
    /// # Errors
    /// Those of `out`; [`io::ErrorKind::InvalidInput`] if `rows` do not fit the field.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::{LayerField, SavedField};
    /// let rows = vec![0b11];
    /// let field = LayerField::new(&Cells::new([2, 1, 1], &rows)?, vec![0.5, f64::NAN], 1.0)?;
    /// let saved = SavedField { field, rows, cell_mm: 0.8, origin: [0.0; 3].into(), mesh: 7, aids: Default::default() };
    /// let mut file = Vec::new();
    /// saved.write(&mut file)?;
    /// let read = SavedField::read(&file[..])?;
    /// assert_eq!((read.field.value(0), read.field.value(1)), (Some(0.5), None));
    /// assert!(read.check_mesh(7).is_ok() && read.check_mesh(8).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let cells = self.cells().map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        let [nx, ny, nz] = cells.dims();
        let Point3 { coords: at } = self.origin;
        writeln!(out, "curvlay field 1\nmesh {:016x}\ngrid {nx} {ny} {nz}\ncell_mm {}", self.mesh, self.cell_mm)?;
        write!(out, "origin_mm {} {} {}\nlayer_cells {}", at.x, at.y, at.z, self.field.layer_cells())?;
        match self.field.steps_per_layer() {
            1 => writeln!(out)?,
            steps => writeln!(out, " {steps}")?,
        }
        if let Some(thicker_than) = self.field.half_layers() {
            writeln!(out, "half_layers {thicker_than}")?;
        }
        writeln!(out, "cells {}", cells.count())?;
        for cell in cells.iter() {
            match self.field.value(cell) {
                Some(value) => writeln!(out, "{cell} {value}")?,
                None => writeln!(out, "{cell} -")?,
            }
        }
        let PrintAids { support, gap, contact, rule, nozzle } = &self.aids;
        let lists = [("support", support), ("gap", gap), ("contact", contact)];
        for (key, cells) in lists.into_iter().filter(|(_, cells)| !cells.is_empty()) {
            writeln!(out, "{key} {}", cells.len())?;
            cells.iter().try_for_each(|cell| writeln!(out, "{cell}"))?;
        }
        if !nozzle.is_empty() {
            let NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, max_tilt, margin } = rule;
            writeln!(out, "nozzle {tip_flat_mm} {half_angle} {cone_height_mm} {block_mm} {max_tilt} {margin}")?;
            writeln!(out, "directions {}", nozzle.len())?;
            for NozzleCell { cell, direction } in nozzle {
                writeln!(out, "{cell} {} {} {}", direction.x, direction.y, direction.z)?;
            }
        }
        writeln!(out, "end")
    }

    /// Reads a field with a grid of at most [`SavedField::MAX_GRID`] cells.
    ///
    /// # Errors
    /// [`ReadFieldError`], with the line. Takes memory by what there is in the file, not by what it announces, and reads no
    /// further than to the first line that is wrong.
    pub fn read(source: impl BufRead) -> Result<Self, ReadFieldError> {
        Self::read_within(Self::MAX_GRID, source)
    }

    /// Reads a field with a grid of at most `max_grid` cells, empty ones included. Each takes 8 bytes.
    ///
    /// # Errors
    /// As [`SavedField::read`].
    pub fn read_within(max_grid: u64, source: impl BufRead) -> Result<Self, ReadFieldError> {
        let mut lines = Lines { source, line: 0, text: String::new() };
        lines.next()?;
        if lines.text != "curvlay field 1" {
            return Err(lines.unlike("`curvlay field 1`"));
        }
        let mesh =
            lines.keyed("mesh", "`mesh` and 16 hexadecimal digits", |text| u64::from_str_radix(text, 16).ok())?;
        let dims = lines.keyed("grid", "`grid` and three numbers of cells", three::<u32>)?;
        let grid = dims.iter().fold(1u64, |product, &side| product.saturating_mul(u64::from(side)));
        if grid > max_grid {
            return Err(ReadFieldError::GridTooLarge { grid, limit: max_grid });
        }
        let cell_mm =
            lines.keyed("cell_mm", "`cell_mm` and a length above 0", |text| number(text).filter(|&mm| mm > 0.0))?;
        let origin = lines.keyed("origin_mm", "`origin_mm` and three finite numbers", |text| {
            three(text).filter(|at: &[f64; 3]| at.iter().all(|c| c.is_finite()))
        })?;
        let (layer_cells, steps) = lines.keyed("layer_cells", "`layer_cells`, a number and perhaps steps", |text| {
            let (layer_cells, steps) = text.split_once(' ').unwrap_or((text, "1"));
            Some((number(layer_cells)?, steps.parse::<u32>().ok().filter(|steps| (1..=MAX_STEPS).contains(steps))?))
        })?;
        lines.next()?;
        let half_layers = lines.value_of("half_layers", |text| number(text).filter(|&heights| heights >= 1.0));
        if half_layers.is_some() {
            lines.next()?;
        }
        let count = lines.value_of("cells", |text| text.parse::<usize>().ok());
        let count = count.ok_or_else(|| lines.unlike("`cells` and their number"))?;
        let mut read: Vec<(u32, f64)> = Vec::new();
        for _ in 0..count {
            lines.next()?;
            let found = lines.text.split_once(' ').and_then(|(cell, value)| {
                let value = if value == "-" { f64::NAN } else { number(value)? };
                Some((cell.parse::<u32>().ok()?, value))
            });
            let Some((cell, value)) = found else {
                return Err(lines.unlike("a cell and its value, or `-` for none,"));
            };
            if u64::from(cell) >= grid || read.last().is_some_and(|last| last.0 >= cell) {
                return Err(ReadFieldError::Cell { line: lines.line, cell, grid });
            }
            read.push((cell, value));
        }
        let aids = lines.aids(&read, grid)?;
        let [per_cell, extra] = MAX_GRID;
        if grid > per_cell.saturating_mul(read.len() as u64).saturating_add(extra) {
            return Err(ReadFieldError::Sparse { grid, cells: read.len() });
        }
        let highest = read.iter().map(|&(_, value)| value).fold(0.0, f64::max);
        let [per_cell, extra] = MAX_HEIGHT;
        if highest.max(1.0) * layer_cells > per_cell * read.len() as f64 + extra {
            return Err(ReadFieldError::TooHigh { highest, layer_cells, cells: read.len() });
        }
        let words = (dims[0].div_ceil(64) as usize).saturating_mul(dims[1] as usize).saturating_mul(dims[2] as usize);
        let mut rows = vec![0; words];
        let mut values = vec![f64::NAN; grid as usize];
        for (cell, value) in read {
            let (row, x) = (cell / dims[0], cell % dims[0]);
            rows[row as usize * dims[0].div_ceil(64) as usize + x as usize / 64] |= 1 << (x % 64);
            values[cell as usize] = value;
        }
        let field = LayerField::new(&Cells::new(dims, &rows)?, values, layer_cells)?;
        let field = field.in_steps(steps).with_half_layers(half_layers);
        Ok(SavedField { field, rows, cell_mm, origin: origin.into(), mesh, aids })
    }
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

fn three<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let mut parts = text.split(' ').map(|part| part.parse().ok());
    let three = [parts.next()??, parts.next()??, parts.next()??];
    parts.next().is_none().then_some(three)
}

/// The lines of a source, known by their numbers.
struct Lines<R> {
    source: R,
    line: usize,
    text: String,
}

impl<R: BufRead> Lines<R> {
    /// Goes on to the next line.
    fn next(&mut self) -> Result<(), ReadFieldError> {
        self.line += 1;
        self.text.clear();
        let line = self.line;
        let mut limited = self.source.by_ref().take(MAX_BYTES);
        limited.read_line(&mut self.text).map_err(|source| ReadFieldError::Io { line, source })?;
        if self.text.len() as u64 == MAX_BYTES {
            return Err(self.unlike("a line of fewer than 4096 bytes"));
        }
        let text = self.text.trim_end_matches(['\n', '\r']).len();
        self.text.truncate(text);
        Ok(())
    }

    /// Goes on to the next line, which is `key` and something that `value` takes.
    fn keyed<T>(
        &mut self,
        key: &str,
        expected: &'static str,
        value: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, ReadFieldError> {
        self.next()?;
        self.value_of(key, value).ok_or_else(|| self.unlike(expected))
    }

    /// What `value` takes from this line, if it begins with `key`.
    fn value_of<T>(&self, key: &str, value: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        self.text.split_once(' ').filter(|(word, _)| *word == key).and_then(|(_, rest)| value(rest))
    }

    /// The cells of a list that begins at this line, if it does; then goes on to the next line.
    fn list(&mut self, key: &str, cells: &[(u32, f64)], grid: u64) -> Result<Vec<u32>, ReadFieldError> {
        let mut list = Vec::new();
        if self.text.split(' ').next() == Some(key) {
            let count = self.count(key, "a word and a number of cells")?;
            for _ in 0..count {
                self.next()?;
                let Ok(cell) = self.text.parse::<u32>() else { return Err(self.unlike("the number of a cell")) };
                self.check_built(cells, grid, cell, list.last().copied())?;
                list.push(cell);
            }
            self.next()?;
        }
        Ok(list)
    }

    /// The support and the directions of the nozzle, if there are any, and the end. `cells` are those of the field, with their values.
    fn aids(&mut self, cells: &[(u32, f64)], grid: u64) -> Result<PrintAids, ReadFieldError> {
        let mut aids = PrintAids::default();
        self.next()?;
        aids.support = self.list("support", cells, grid)?;
        aids.gap = self.list("gap", cells, grid)?;
        aids.contact = self.list("contact", cells, grid)?;
        if self.text.starts_with("nozzle ") {
            let numbers = self.text.split(' ').skip(1).map(number).collect::<Option<Vec<f64>>>();
            let Some([tip_flat_mm, half_angle, cone_height_mm, block_mm, max_tilt, margin]) =
                numbers.and_then(|numbers| <[f64; 6]>::try_from(numbers).ok())
            else {
                return Err(self.unlike("`nozzle` and six numbers"));
            };
            aids.rule = NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, max_tilt, margin };
            aids.rule.check()?;
            self.next()?;
            let count = self.count("directions", "`directions` and their number")?;
            for _ in 0..count {
                self.next()?;
                let found = self.text.split_once(' ').and_then(|(cell, direction)| {
                    let direction = Vector3::from(three::<f64>(direction)?);
                    // Written with all digits, so that reading changes nothing.
                    let is_unit = (direction.norm() - 1.0).abs() < 1e-9;
                    Some((cell.parse::<u32>().ok()?, UnitVector3::new_unchecked(direction))).filter(|_| is_unit)
                });
                let Some((cell, direction)) = found else {
                    return Err(self.unlike("a cell and a direction of length 1"));
                };
                self.check_built(cells, grid, cell, aids.nozzle.last().map(|last| last.cell))?;
                aids.nozzle.push(NozzleCell { cell, direction });
            }
            self.next()?;
        }
        if self.text != "end" {
            return Err(self.unlike("`end`"));
        }
        Ok(aids)
    }

    /// The number behind the word at the start of the line.
    fn count(&self, key: &str, expected: &'static str) -> Result<usize, ReadFieldError> {
        self.value_of(key, |text| text.parse().ok()).ok_or_else(|| self.unlike(expected))
    }

    /// Whether a cell has a value and comes after the one before.
    fn check_built(
        &self,
        cells: &[(u32, f64)],
        grid: u64,
        cell: u32,
        before: Option<u32>,
    ) -> Result<(), ReadFieldError> {
        let place = cells.binary_search_by_key(&cell, |&(cell, _)| cell);
        let is_built = place.is_ok_and(|place| !cells[place].1.is_nan());
        if is_built && before.is_none_or(|before| before < cell) {
            return Ok(());
        }
        Err(ReadFieldError::Cell { line: self.line, cell, grid })
    }

    fn unlike(&self, expected: &'static str) -> ReadFieldError {
        ReadFieldError::Line { line: self.line, expected, found: self.text.chars().take(40).collect() }
    }
}
