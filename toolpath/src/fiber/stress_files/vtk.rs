//! Stresses at points in VTK legacy files, as text.
//!
//! "VTK file formats", Kitware: a `DATASET` with `POINTS` (structured points have an `ORIGIN`, a `SPACING` and `DIMENSIONS` instead), and `POINT_DATA`
//! with `TENSORS` (nine numbers a point), or an array of six or nine components in a `FIELD`. Six are `xx yy zz xy yz zx`, nine row by row. Numbers are separated by any white space.

use super::{Lines, StressFileError, number, sample};
use crate::fiber::stress::StressSample;
use std::io::BufRead;

/// Reads the first array of tensors at points: `TENSORS`, or one of six or nine components in a field.
///
/// # Arguments
/// * `name`: of the array; without one the first that can be a tensor is taken.
///
/// # Errors
/// [`StressFileError`], with the line. Binary files are refused.
///
/// # Cost
/// `O(n)` for `n` bytes.
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::stress_files::read_stress_vtk;
/// let file = "# vtk DataFile Version 3.0\ntwo points\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 float\n0 0 0 1 2 3\n\
///             POINT_DATA 2\nTENSORS stress float\n1 4 6 4 2 5 6 5 3\n7 0 0 0 8 0 0 0 9\n";
/// let samples = read_stress_vtk(file.as_bytes(), None)?;
/// assert_eq!((samples[1].point.z, samples[0].stress[(0, 2)], samples[1].stress[(2, 2)]), (3.0, 6.0, 9.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stress_vtk(input: impl BufRead, name: Option<&str>) -> Result<Vec<StressSample>, StressFileError> {
    let mut words = Words { lines: Lines::new(input), left: Vec::new() };
    words.header()?;
    let (mut points, mut grid, mut at_points) = (None, Grid::default(), None);
    while let Some(word) = words.next()? {
        match word.to_ascii_uppercase().as_str() {
            "POINTS" => {
                let count = words.count("the number of points")?;
                words.need("the type of the points")?;
                points = Some(words.numbers::<3>(count)?);
            }
            "DIMENSIONS" => {
                let [x, y, z] = [words.count("a dimension")?, words.count("a dimension")?, words.count("a dimension")?];
                grid.dims = Some([x, y, z]);
            }
            "ORIGIN" => grid.origin = words.three("an origin")?,
            "SPACING" | "ASPECT_RATIO" => grid.spacing = words.three("a spacing")?,
            "POINT_DATA" => at_points = Some(words.count("the number of points")?),
            "CELL_DATA" => at_points = None,
            "TENSORS" if at_points.is_some() => {
                let array = words.need("the name of the tensors")?;
                words.need("the type of the tensors")?;
                let tensors = words.numbers::<9>(at_points.unwrap_or(0))?;
                if name.is_none_or(|name| name == array) {
                    return samples(&words, points, grid, tensors);
                }
            }
            "FIELD" if at_points.is_some() => {
                if let Some(tensors) = words.field(name)? {
                    return samples(&words, points, grid, tensors);
                }
            }
            _ => {}
        }
    }
    Err(StressFileError::NoStress { expected: "it has no TENSORS and no array of six or nine components at points" })
}

/// Points without a list.
#[derive(Default)]
struct Grid {
    dims: Option<[u64; 3]>,
    origin: [f64; 3],
    spacing: [f64; 3],
}

fn samples<R: BufRead>(
    words: &Words<R>,
    points: Option<Vec<[f64; 3]>>,
    grid: Grid,
    tensors: Vec<[f64; 9]>,
) -> Result<Vec<StressSample>, StressFileError> {
    let points = match (points, grid.dims) {
        (Some(points), _) => points,
        (None, Some(dims)) => {
            let count = dims.iter().fold(1, |count: u64, &n| count.saturating_mul(n));
            if count != tensors.len() as u64 {
                let (line, wanted) = (words.lines.line, usize::try_from(count).unwrap_or(usize::MAX));
                return Err(StressFileError::Columns { line, found: tensors.len(), wanted });
            }
            let [nx, ny, _] = dims.map(|n| n as usize);
            let place = |k: usize| [k % nx, k / nx % ny, k / nx / ny];
            (0..tensors.len())
                .map(|k| [0, 1, 2].map(|i| grid.origin[i] + grid.spacing[i] * place(k)[i] as f64))
                .collect()
        }
        (None, None) => return Err(words.lines.ends("POINTS or DIMENSIONS before the stresses")),
    };
    if points.len() != tensors.len() {
        return Err(StressFileError::Columns { line: words.lines.line, found: tensors.len(), wanted: points.len() });
    }
    let of = |(point, (place, t)): (usize, ([f64; 3], [f64; 9]))| {
        let largest = t.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let pairs = [(1, 3), (2, 6), (5, 7)];
        if pairs.iter().any(|&(a, b): &(usize, usize)| (t[a] - t[b]).abs() > crate::fiber::stress::SYMMETRY * largest) {
            return Err(StressFileError::NotSymmetric { line: words.lines.line, point });
        }
        let mean = |a: usize, b: usize| 0.5 * (t[a] + t[b]);
        Ok(sample(place, [t[0], t[4], t[8], mean(1, 3), mean(5, 7), mean(2, 6)]))
    };
    points.into_iter().zip(tensors).enumerate().map(of).collect()
}

/// The words of a file.
struct Words<R> {
    lines: Lines<R>,
    /// Words left of the line, the next one last.
    left: Vec<String>,
}

impl<R: BufRead> Words<R> {
    /// The three lines that begin a file, the last of which says that it is text.
    fn header(&mut self) -> Result<(), StressFileError> {
        let first = self.lines.next()?.map(str::to_owned);
        let first = first.ok_or_else(|| self.lines.ends("`# vtk DataFile Version`"))?;
        if !first.starts_with("# vtk DataFile Version") {
            return Err(self.lines.unexpected("`# vtk DataFile Version`", &first));
        }
        self.lines.next()?;
        let kind = self.lines.next()?.map(str::to_owned).ok_or_else(|| self.lines.ends("`ASCII`"))?;
        match kind.trim() {
            "ASCII" => Ok(()),
            other => Err(self.lines.unexpected("`ASCII`: only text can be read", other)),
        }
    }

    fn next(&mut self) -> Result<Option<String>, StressFileError> {
        while self.left.is_empty() {
            let Some(text) = self.lines.next()? else { return Ok(None) };
            self.left = text.split_whitespace().rev().map(str::to_owned).collect();
        }
        Ok(self.left.pop())
    }

    fn need(&mut self, expected: &'static str) -> Result<String, StressFileError> {
        self.next()?.ok_or_else(|| self.lines.ends(expected))
    }

    fn count(&mut self, expected: &'static str) -> Result<u64, StressFileError> {
        let word = self.need(expected)?;
        word.parse().map_err(|_| self.lines.unexpected(expected, &word))
    }

    fn number(&mut self, expected: &'static str) -> Result<f64, StressFileError> {
        let word = self.need(expected)?;
        number(self.lines.line, &word)
    }

    fn three(&mut self, expected: &'static str) -> Result<[f64; 3], StressFileError> {
        let mut three = [0.0; 3];
        for value in &mut three {
            *value = self.number(expected)?;
        }
        Ok(three)
    }

    /// Tuples of numbers. Memory grows with what is there, not with what the file says.
    fn numbers<const N: usize>(&mut self, count: u64) -> Result<Vec<[f64; N]>, StressFileError> {
        let mut found = Vec::new();
        for _ in 0..count {
            let mut tuple = [0.0; N];
            for value in &mut tuple {
                *value = self.number("a number")?;
            }
            found.push(tuple);
        }
        Ok(found)
    }

    /// The first array of a field that can be a tensor and has the name.
    fn field(&mut self, name: Option<&str>) -> Result<Option<Vec<[f64; 9]>>, StressFileError> {
        self.need("the name of the field")?;
        let arrays = self.count("the number of arrays")?;
        for _ in 0..arrays {
            let array = self.need("the name of an array")?;
            let components = self.count("the number of components")?;
            let tuples = self.count("the number of tuples")?;
            let kind = self.need("the type of an array")?;
            let wanted = name.is_none_or(|name| name == array);
            match components {
                6 if wanted => {
                    let nine = |[xx, yy, zz, xy, yz, zx]: [f64; 6]| [xx, xy, zx, xy, yy, yz, zx, yz, zz];
                    return Ok(Some(self.numbers::<6>(tuples)?.into_iter().map(nine).collect()));
                }
                9 if wanted => return self.numbers::<9>(tuples).map(Some),
                _ if name == Some(array.as_str()) => {
                    let found = components as usize;
                    return Err(StressFileError::Columns { line: self.lines.line, found, wanted: 6 });
                }
                _ if kind == "string" => return Err(self.lines.unexpected("an array of numbers", &kind)),
                _ => {
                    for _ in 0..components.saturating_mul(tuples) {
                        self.need("a number")?;
                    }
                }
            }
        }
        Ok(None)
    }
}
