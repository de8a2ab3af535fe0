//! Tables of cells: `x,y,z,layer` in millimetres, `i,j,k,layer` as indices, and our `field.csv`.

use super::lattice::Lattice;
use super::order::{CellOrder, Entry, OrderFault, OrderOptions, checked_dims, layer_of};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::io::BufRead;

/// Which column is what.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Columns {
    place: [usize; 3],
    is_index: bool,
    layer: usize,
    direction: Option<[usize; 3]>,
    count: usize,
    meant: String,
}

/// Lines longer than this are of another kind of file, in bytes.
const MAX_LINE: u64 = 1 << 14;
/// Indices and millimetres beyond this are a slip.
const MAX_PLACE: f64 = 1e7;

/// Reads a table. Places in millimetres are centres of cells on a lattice, whose step is `--cell` or the least difference of coordinates.
pub fn read(reader: impl BufRead, options: &OrderOptions) -> Result<CellOrder, OrderFault> {
    let mut columns: Option<Columns> = None;
    let mut rows: Vec<Row> = Vec::new();
    for_each_line(reader, |number, line| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let columns = match &columns {
            Some(columns) => columns,
            None => match headed(&cells, number)? {
                Some(found) => {
                    columns = Some(found);
                    return Ok(());
                }
                None => columns.insert(headless(&cells, number)?),
            },
        };
        rows.push(row(&cells, columns, number, options)?);
        if rows.len() as u64 > options.max_cells {
            return Err(OrderFault::at(number, format!("more lines than --max-cells {}", options.max_cells)));
        }
        Ok(())
    })?;
    let Some(columns) = columns.filter(|_| !rows.is_empty()) else {
        return Err(OrderFault::at(0, "there is no cell in it: a line is x,y,z,layer"));
    };
    placed(rows, &columns, options)
}

fn for_each_line(
    mut reader: impl BufRead,
    mut take: impl FnMut(usize, &str) -> Result<(), OrderFault>,
) -> Result<(), OrderFault> {
    let mut bytes = Vec::new();
    for number in 1.. {
        bytes.clear();
        let mut limited = std::io::Read::take(&mut reader, MAX_LINE);
        limited.read_until(b'\n', &mut bytes).map_err(|error| OrderFault::at(number, error.to_string()))?;
        if bytes.is_empty() {
            break;
        }
        if bytes.len() as u64 >= MAX_LINE {
            return Err(OrderFault::at(number, format!("longer than {MAX_LINE} bytes: is it a table of cells?")));
        }
        let text = std::str::from_utf8(&bytes).map_err(|_| OrderFault::at(number, "not UTF-8: is it a text file?"))?;
        let line = text.trim_start_matches('\u{feff}').trim();
        if !line.is_empty() && !line.starts_with('#') {
            take(number, line)?;
        }
    }
    Ok(())
}

/// The columns of a header; `None` for a line of numbers.
fn headed(cells: &[&str], line: usize) -> Result<Option<Columns>, OrderFault> {
    if cells.iter().all(|cell| cell.parse::<f64>().is_ok()) {
        return Ok(None);
    }
    let names: Vec<String> = cells.iter().map(|cell| cell.trim_matches('"').to_ascii_lowercase()).collect();
    let at = |name: &str| names.iter().position(|known| known == name);
    let three = |names: [&str; 3]| Some([at(names[0])?, at(names[1])?, at(names[2])?]);
    let place =
        three(["x_mm", "y_mm", "z_mm"]).map(|place| (place, false, "x_mm, y_mm, z_mm as centres in millimetres"));
    let place = place.or_else(|| three(["i", "j", "k"]).map(|place| (place, true, "i, j, k as places in the grid")));
    let place =
        place.or_else(|| three(["x", "y", "z"]).map(|place| (place, false, "x, y, z as centres in millimetres")));
    let Some((place, is_index, meant)) = place else {
        return Err(OrderFault::at(line, "no columns x,y,z or x_mm,y_mm,z_mm or i,j,k: is it an order of cells?"));
    };
    let Some((layer, name)) = ["cell_layer", "layer"].into_iter().find_map(|name| Some((at(name)?, name))) else {
        return Err(OrderFault::at(line, "no column `layer` or `cell_layer`: the order of the cells is not said"));
    };
    let direction = three(["nx", "ny", "nz"]);
    let nozzle = if direction.is_some() { ", nx, ny, nz as the direction of the nozzle" } else { "" };
    Ok(Some(Columns {
        place,
        is_index,
        layer,
        direction,
        count: names.len(),
        meant: format!("{meant}, {name} as the layer{nozzle}"),
    }))
}

fn headless(cells: &[&str], line: usize) -> Result<Columns, OrderFault> {
    let (direction, nozzle) = match cells.len() {
        4 => (None, ""),
        7 => (Some([4, 5, 6]), ", columns 5 to 7 as the direction of the nozzle"),
        count => return Err(OrderFault::at(line, format!("{count} numbers and no header: expected x,y,z,layer"))),
    };
    let meant = format!("columns 1 to 3 as centres in millimetres, 4 as the layer{nozzle} (no header)");
    Ok(Columns { place: [0, 1, 2], is_index: false, layer: 3, direction, count: cells.len(), meant })
}

/// A line: its number, the place, the layer, and the direction of the nozzle.
type Row = (usize, [f64; 3], u32, Option<UnitVector3<f64>>);

fn row(cells: &[&str], columns: &Columns, line: usize, options: &OrderOptions) -> Result<Row, OrderFault> {
    if cells.len() != columns.count {
        let what = format!("{} columns, the first line has {}", cells.len(), columns.count);
        return Err(OrderFault::at(line, what));
    }
    let number = |column: usize| {
        let value = cells[column].parse::<f64>().ok().filter(|value| value.abs() <= MAX_PLACE);
        let shown: String = cells[column].chars().take(40).collect();
        let limit = "not a number within 1e7";
        value.ok_or_else(|| OrderFault::at(line, format!("column {} is `{shown}`, {limit}", column + 1)))
    };
    let [x, y, z] = columns.place;
    let place = [number(x)?, number(y)?, number(z)?];
    let wrong_layer = || {
        let shown: String = cells[columns.layer].chars().take(40).collect();
        OrderFault::at(line, format!("the layer is `{shown}`, not a whole number up to 100 million"))
    };
    let layer = number(columns.layer).ok().and_then(|value| layer_of(value, options)).ok_or_else(wrong_layer)?;
    // Cells that are not built may leave it empty.
    let is_said = |all: &[usize; 3]| all.iter().all(|&column| !cells[column].is_empty());
    let direction = match columns.direction.filter(is_said) {
        None => None,
        Some([x, y, z]) => {
            let vector = Vector3::new(number(x)?, number(y)?, number(z)?);
            let unit = UnitVector3::try_new(vector, 1e-6);
            Some(unit.ok_or_else(|| OrderFault::at(line, "the direction of the nozzle has no length"))?)
        }
    };
    Ok((line, place, layer, direction))
}

fn placed(rows: Vec<Row>, columns: &Columns, options: &OrderOptions) -> Result<CellOrder, OrderFault> {
    let places = || rows.iter().map(|(line, place, ..)| (*line, *place));
    let lattice = if columns.is_index {
        Lattice::of_indices(places(), options.cell_mm.unwrap_or(1.0))?
    } else {
        Lattice::of_centres(places(), options.cell_mm)?
    };
    let dims = checked_dims(lattice.sides, options, 0)?;
    let mut entries = Vec::with_capacity(rows.len());
    for (line, place, layer, direction) in &rows {
        entries.push(Entry { cell: lattice.cell(*line, *place)?, layer: *layer, direction: *direction });
    }
    let origin = Point3::from(lattice.corner());
    Ok(CellOrder { dims, cell_mm: lattice.cell_mm, origin, entries, meant: columns.meant.clone() })
}
