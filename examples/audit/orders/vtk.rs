//! Legacy VTK files of structured points, in ASCII: a scalar for each cell, or for each point.
//!
//! W. Schroeder, K. Martin, B. Lorensen, *The VTK User's Guide*, "VTK File Formats".

use super::order::{CellOrder, Entry, MAX_LAYER, OrderFault, OrderOptions, checked_dims, layer_by_value, layer_of};
use nalgebra::Point3;
use std::io::BufRead;

/// Words of a file, each with its line.
struct Words<R> {
    reader: R,
    line: usize,
    /// The line whose words are being read, and where the next one is looked for. A line may hold millions of words: they are not kept one by one.
    text: String,
    at: usize,
}

/// Longest line, in bytes: a row of a large grid on one line has less.
const MAX_LINE: u64 = 1 << 26;

impl<R: BufRead> Words<R> {
    fn next_line(&mut self) -> Result<Option<String>, OrderFault> {
        let mut bytes = Vec::new();
        self.line += 1;
        let mut limited = std::io::Read::take(&mut self.reader, MAX_LINE);
        let read = limited.read_until(b'\n', &mut bytes);
        read.map_err(|error| OrderFault::at(self.line, error.to_string()))?;
        if bytes.is_empty() {
            return Ok(None);
        }
        let text = String::from_utf8(bytes);
        text.map(Some).map_err(|_| OrderFault::at(self.line, "not text: export the file as ASCII"))
    }

    fn next(&mut self) -> Result<Option<String>, OrderFault> {
        loop {
            let rest = &self.text[self.at..];
            if let Some(word) = rest.split_ascii_whitespace().next() {
                let begin = rest.len() - rest.trim_ascii_start().len();
                let word = word.to_owned();
                self.at += begin + word.len();
                return Ok(Some(word));
            }
            let Some(line) = self.next_line()? else { return Ok(None) };
            (self.text, self.at) = (line, 0);
        }
    }

    fn word(&mut self, wanted: &str) -> Result<String, OrderFault> {
        self.next()?.ok_or_else(|| OrderFault::at(self.line, format!("the file ends where {wanted} belongs")))
    }

    fn number(&mut self, wanted: &str) -> Result<f64, OrderFault> {
        let word = self.word(wanted)?;
        let number = word.parse::<f64>().ok().filter(|number| number.abs() <= 1e12);
        number.ok_or_else(|| {
            let shown: String = word.chars().take(40).collect();
            OrderFault::at(self.line, format!("`{shown}` is not {wanted}"))
        })
    }

    fn three(&mut self, wanted: &str) -> Result<[f64; 3], OrderFault> {
        Ok([self.number(wanted)?, self.number(wanted)?, self.number(wanted)?])
    }
}

/// What the header says.
#[derive(Clone, Copy, Debug, Default)]
struct Header {
    points: Option<[f64; 3]>,
    origin: [f64; 3],
    spacing: Option<[f64; 3]>,
    /// Values are of cells, else of points.
    is_cells: bool,
    values: Option<f64>,
}

/// Reads the first scalar field of a file.
pub fn read(reader: impl BufRead, options: &OrderOptions) -> Result<CellOrder, OrderFault> {
    let mut words = Words { reader, line: 0, text: String::new(), at: 0 };
    words.next_line()?; // `# vtk DataFile Version 3.0`, and a title, which may hold anything
    words.next_line()?;
    let coding = words.word("ASCII")?;
    if coding != "ASCII" {
        return Err(OrderFault::at(words.line, format!("the data are {coding}: export the file as ASCII")));
    }
    let mut header = Header::default();
    let name = loop {
        match words.word("SCALARS")?.to_ascii_uppercase().as_str() {
            "DATASET" => {
                let kind = words.word("STRUCTURED_POINTS")?;
                if !kind.eq_ignore_ascii_case("STRUCTURED_POINTS") {
                    let what = format!("the data are {kind}: cells of a grid are STRUCTURED_POINTS");
                    return Err(OrderFault::at(words.line, what));
                }
            }
            "DIMENSIONS" => header.points = Some(words.three("a number of points")?),
            "ORIGIN" => header.origin = words.three("a coordinate")?,
            "SPACING" | "ASPECT_RATIO" => header.spacing = Some(words.three("a spacing")?),
            kind @ ("CELL_DATA" | "POINT_DATA") => {
                header.is_cells = kind == "CELL_DATA";
                header.values = Some(words.number("a number of values")?);
            }
            "SCALARS" => break words.word("the name of the scalars")?,
            other => return Err(OrderFault::at(words.line, format!("`{other}` is not read here"))),
        }
    };
    grid_of(header, &name, words, options)
}

fn grid_of<R: BufRead>(
    header: Header,
    name: &str,
    mut words: Words<R>,
    options: &OrderOptions,
) -> Result<CellOrder, OrderFault> {
    let line = words.line;
    let (Some(points), Some(spacing)) = (header.points, header.spacing) else {
        return Err(OrderFault::at(line, "DIMENSIONS or SPACING is missing before SCALARS"));
    };
    let less = if header.is_cells { 1.0 } else { 0.0 };
    let sides = points.map(|side| (side - less).clamp(0.0, 1e9) as u64);
    let dims = checked_dims(sides, options, line)?;
    let cell_mm = spacing[0];
    let is_cube = spacing.iter().all(|side| (side - cell_mm).abs() <= 1e-6 * cell_mm.abs());
    if !(cell_mm > 0.0 && is_cube && header.origin.iter().all(|at| at.abs() <= 1e7)) {
        return Err(OrderFault::at(
            line,
            "cells must be cubes with an edge above 0 (SPACING), near the origin (ORIGIN)",
        ));
    }
    let count: u64 = dims.iter().map(|&side| u64::from(side)).product();
    if header.values.is_some_and(|values| (values - count as f64).abs() > 0.5) {
        let what = format!("{} values for {count} cells", header.values.unwrap_or(0.0));
        return Err(OrderFault::at(line, what));
    }
    words.word("the type of the scalars")?;
    let mut first = words.word("LOOKUP_TABLE or values")?;
    if first == "1" {
        first = words.word("LOOKUP_TABLE")?;
    }
    if first != "LOOKUP_TABLE" {
        return Err(OrderFault::at(words.line, "expected `LOOKUP_TABLE default`, with one value for each cell"));
    }
    words.word("the name of the table")?;
    let low = if header.is_cells { 0.0 } else { -0.5 * cell_mm };
    let origin = Point3::from(header.origin.map(|at| at + low));
    let is_layers = name.to_ascii_lowercase().contains("layer");
    let mut order = CellOrder { dims, cell_mm, origin, entries: Vec::new(), meant: meant(name, is_layers, options) };
    let [nx, ny, _] = dims.map(u64::from);
    for id in 0..count {
        let value = words.number("a value")?;
        let cell = [id % nx, id / nx % ny, id / nx / ny].map(|at| at as u32);
        if value < 0.0 {
            continue;
        }
        let layer = match (is_layers, options.field_step) {
            (true, _) => layer_of(value, options),
            (false, step) => layer_by_value(value, step.unwrap_or(1.0)),
        };
        let wrong = || OrderFault::at(words.line, format!("{value} is no layer: a whole number up to {MAX_LAYER}"));
        let layer = layer.ok_or_else(wrong)?;
        order.entries.push(Entry { cell, layer, direction: None });
    }
    if order.entries.is_empty() {
        return Err(OrderFault::at(words.line, "no cell has a value of 0 or more: there is nothing to audit"));
    }
    Ok(order)
}

fn meant(name: &str, is_layers: bool, options: &OrderOptions) -> String {
    let shown: String = name.chars().filter(|c| !c.is_control()).take(40).collect();
    match is_layers {
        true => format!("the scalars `{shown}` as layers"),
        false => {
            let step = options.field_step.unwrap_or(1.0);
            format!("the scalars `{shown}` as a growth field, in layers of {step} (--field-step)")
        }
    }
}
