//! Stresses as CSV: positions and six components, nothing quoted.

use super::{Lines, StressFileError, number, sample};
use crate::fiber::stress::{SIX, StressSample};
use std::io::{self, BufRead, BufWriter, Write};

/// The first line of a file that is written.
pub const STRESS_CSV_HEADER: &str = "x_mm,y_mm,z_mm,s_xx,s_yy,s_zz,s_xy,s_yz,s_zx";

/// Reads positions and six components: `x, y, z, xx, yy, zz, xy, yz, zx`.
///
/// Columns are separated by commas, semicolons or tabs. A first line without a number is a header; its names do not matter, their order is as above.
/// Empty lines, and those that begin with `#`, are passed over.
///
/// # Errors
/// [`StressFileError`], with the line.
///
/// # Cost
/// `O(n)` for `n` bytes.
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::stress_files::read_stress_csv;
/// let samples = read_stress_csv(&b"x,y,z,xx,yy,zz,xy,yz,zx\n1,2,3,10,20,30,4,5,6\n"[..])?;
/// assert_eq!((samples[0].point.z, samples[0].stress[(1, 1)], samples[0].stress[(2, 1)]), (3.0, 20.0, 5.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stress_csv(input: impl BufRead) -> Result<Vec<StressSample>, StressFileError> {
    let (mut lines, mut samples, mut first) = (Lines::new(input), Vec::new(), true);
    loop {
        let number_of_line = lines.line + 1;
        let Some(text) = lines.next()? else { break };
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let columns: Vec<&str> = text.split([',', ';', '\t']).map(str::trim).collect();
        if columns.len() != 9 {
            return Err(StressFileError::Columns { line: number_of_line, found: columns.len(), wanted: 9 });
        }
        let header = std::mem::take(&mut first) && columns.iter().all(|column| column.parse::<f64>().is_err());
        if header {
            continue;
        }
        let mut values = [0.0; 9];
        for (value, column) in values.iter_mut().zip(columns) {
            *value = number(number_of_line, column)?;
        }
        let [x, y, z, six @ ..] = values;
        samples.push(sample([x, y, z], six));
    }
    if samples.is_empty() {
        return Err(StressFileError::NoStress { expected: "no line has a position and six components" });
    }
    Ok(samples)
}

/// Writes positions and six components, every digit, under [`STRESS_CSV_HEADER`].
///
/// # Errors
/// What the system says.
///
/// # Cost
/// Constant memory, `O(n)` for `n` samples.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Matrix3, Point3};
/// use curvlay_toolpath::fiber::stress::StressSample;
/// use curvlay_toolpath::fiber::stress_files::{read_stress_csv, write_stress_csv};
/// let samples = [StressSample { point: Point3::new(0.1, 2.0, 3.0), stress: Matrix3::identity() / 3.0 }];
/// let mut file = Vec::new();
/// write_stress_csv(&samples, &mut file)?;
/// assert_eq!(read_stress_csv(&file[..])?, samples);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_stress_csv(samples: &[StressSample], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "{STRESS_CSV_HEADER}")?;
    for StressSample { point, stress } in samples {
        write!(out, "{},{},{}", point.x, point.y, point.z)?;
        for at in SIX {
            write!(out, ",{}", stress[at])?;
        }
        writeln!(out)?;
    }
    out.flush()
}
