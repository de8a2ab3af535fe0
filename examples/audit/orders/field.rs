//! Our `field.txt`: an even field of cells, with the directions of the nozzle at some of them.

use super::{CellOrder, Entry, OrderFault, OrderOptions, checked_dims, layer_by_value};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::collections::HashMap;
use std::io::BufRead;

/// Lists that are passed over, each with a cell a line.
const LISTS: [&str; 3] = ["support", "gap", "contact"];

#[derive(Default)]
struct Parsed {
    grid: Option<[u64; 3]>,
    cell_mm: Option<f64>,
    origin: Option<[f64; 3]>,
    layer_cells: Option<f64>,
    values: Vec<(u32, Option<f64>)>,
    directions: HashMap<u32, UnitVector3<f64>>,
    is_whole: bool,
}

/// Reads the cells with their values, which become layers of one cell each unless `--field-step` says otherwise.
pub fn read(reader: impl BufRead, options: &OrderOptions) -> Result<CellOrder, OrderFault> {
    let mut lines = reader.lines().enumerate().map(|(at, line)| match line {
        Ok(line) => Ok((at + 1, line)),
        Err(error) => Err(OrderFault::at(at + 1, error.to_string())),
    });
    let mut parsed = Parsed::default();
    while let Some((number, line)) = lines.next().transpose()? {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let count = || count(&words, number, options);
        match words.first().copied() {
            Some("grid") => parsed.grid = Some(numbers(&words, number)?.map(|side| side.clamp(0.0, 1e9) as u64)),
            Some("origin_mm") => parsed.origin = Some(numbers(&words, number)?),
            Some("cell_mm") => parsed.cell_mm = Some(numbers::<1>(&words, number)?[0]),
            Some("layer_cells") => parsed.layer_cells = Some(numbers::<1>(&words, number)?[0]),
            Some("cells") => {
                for _ in 0..count()? {
                    let (number, line) = lines.next().transpose()?.ok_or_else(|| cut(number))?;
                    parsed.values.push(value(&line, number)?);
                }
            }
            Some("directions") => {
                for _ in 0..count()? {
                    let (number, line) = lines.next().transpose()?.ok_or_else(|| cut(number))?;
                    let words: Vec<&str> = line.split_ascii_whitespace().collect();
                    let [x, y, z] = numbers(&words, number)?;
                    let cell = words[0].parse().map_err(|_| OrderFault::at(number, "no cell and direction"))?;
                    let unit = UnitVector3::try_new(Vector3::new(x, y, z), 1e-6);
                    parsed.directions.insert(cell, unit.ok_or_else(|| OrderFault::at(number, "no direction"))?);
                }
            }
            Some(list) if LISTS.contains(&list) => {
                for _ in 0..count()? {
                    lines.next().transpose()?.ok_or_else(|| cut(number))?;
                }
            }
            Some("end") => parsed.is_whole = true,
            _ => {}
        }
    }
    order(parsed, options)
}

fn cut(line: usize) -> OrderFault {
    OrderFault::at(line, "the file ends within a list: it is cut short")
}

fn count(words: &[&str], line: usize, options: &OrderOptions) -> Result<u64, OrderFault> {
    let count = words.get(1).and_then(|word| word.parse::<u64>().ok());
    let count = count.ok_or_else(|| OrderFault::at(line, "a list without its length"))?;
    if count <= options.max_cells { Ok(count) } else { Err(OrderFault::at(line, "a list longer than --max-cells")) }
}

/// The numbers behind the first word.
fn numbers<const N: usize>(words: &[&str], line: usize) -> Result<[f64; N], OrderFault> {
    let all: Option<Vec<f64>> = words.iter().skip(1).take(N).map(|word| word.parse().ok()).collect();
    let all = all.filter(|all| all.iter().all(|number: &f64| number.abs() <= 1e9));
    let all = all.and_then(|all| <[f64; N]>::try_from(all).ok());
    all.ok_or_else(|| OrderFault::at(line, format!("expected {N} numbers behind the first word")))
}

fn value(line: &str, number: usize) -> Result<(u32, Option<f64>), OrderFault> {
    let wrong = || OrderFault::at(number, "expected a cell and its value");
    let (cell, value) = line.trim().split_once(' ').ok_or_else(wrong)?;
    let cell = cell.parse().map_err(|_| wrong())?;
    match value.trim() {
        "-" => Ok((cell, None)),
        value => {
            let value = value.parse::<f64>().ok().filter(|value| (0.0..=1e9).contains(value));
            Ok((cell, Some(value.ok_or_else(wrong)?)))
        }
    }
}

fn order(parsed: Parsed, options: &OrderOptions) -> Result<CellOrder, OrderFault> {
    let missing = |what: &str| OrderFault::at(0, format!("`{what}` is missing: the file is cut short"));
    let dims = checked_dims(parsed.grid.ok_or_else(|| missing("grid"))?, options, 0)?;
    let cell_mm = parsed.cell_mm.filter(|cell| *cell > 0.0).ok_or_else(|| missing("cell_mm"))?;
    let origin = Point3::from(parsed.origin.ok_or_else(|| missing("origin_mm"))?);
    let layer_cells = parsed.layer_cells.filter(|cells| *cells > 0.0).ok_or_else(|| missing("layer_cells"))?;
    if !parsed.is_whole {
        return Err(missing("end"));
    }
    let step = options.field_step.unwrap_or(1.0 / layer_cells);
    let [nx, ny, _] = dims;
    let len = dims.iter().map(|&side| u64::from(side)).product::<u64>();
    let mut entries = Vec::with_capacity(parsed.values.len());
    for (id, value) in parsed.values {
        if u64::from(id) >= len {
            return Err(OrderFault::at(0, format!("there is no cell {id} in a grid of {len} cells")));
        }
        let layer = value.map_or(Some(0), |value| layer_by_value(value, step));
        let layer = layer.ok_or_else(|| OrderFault::at(0, "too many layers: give a larger --field-step"))?;
        let cell = [id % nx, id / nx % ny, id / nx / ny];
        entries.push(Entry { cell, layer, direction: parsed.directions.get(&id).copied() });
    }
    if entries.is_empty() {
        return Err(OrderFault::at(0, "there is no cell in it"));
    }
    let meant = format!("the even field in layers of {step:.4} (--field-step)");
    Ok(CellOrder { dims, cell_mm, origin, entries, meant })
}
