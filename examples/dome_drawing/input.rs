//! The design: read from a file, or made in code.

use super::fault::fault;
use super::{Args, DrawingUnit, design};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_toolpath::drawing::{Drawing, SvgOptions, SvgScale, load_drawing, read_dxf, read_svg};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Largest file that is read: a design of thousands of contours has some megabytes.
const MAX_BYTES: u64 = 256 << 20;

/// The name of the design, and the design.
pub fn read(args: &Args) -> Result<(String, Drawing), Failure> {
    let name = |path: &Path| path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    check_scale(args)?;
    if let Some(path) = &args.dxf {
        let mut drawing = read_dxf(open(path)?).map_err(|error| fault(path, error))?;
        if let Some(unit) = args.unit {
            drawing.set_unit(unit.mm());
        }
        return Ok((name(path), drawing));
    }
    if let Some(path) = &args.svg {
        let mut bytes = Vec::new();
        open(path)?.read_to_end(&mut bytes).map_err(|error| fault(path, error))?;
        let scale = match (args.unit, args.dpi) {
            (Some(unit), _) => SvgScale::UnitMm(unit.mm()),
            (None, Some(dpi)) => SvgScale::Dpi(dpi),
            (None, None) => SvgScale::Css,
        };
        return Ok((name(path), read_svg(&bytes, SvgOptions { scale }).map_err(|error| fault(path, error))?));
    }
    if let Some(path) = &args.load {
        return Ok((name(path), load_drawing(open(path)?).map_err(|error| fault(path, error))?));
    }
    Ok((typed_name(args.design), design::drawing(args.design)))
}

/// The options that say how large a design is go with files that do not.
fn check_scale(args: &Args) -> Result<(), Failure> {
    if args.unit.is_some() && args.dxf.is_none() && args.svg.is_none() {
        return Err(Failure::of_arguments("--unit goes with a DXF or SVG file"));
    }
    if args.dpi.is_some() && args.svg.is_none() {
        return Err(Failure::of_arguments("--dpi goes with an SVG file"));
    }
    Ok(())
}

impl DrawingUnit {
    fn mm(self) -> f64 {
        match self {
            DrawingUnit::Mm => 1.0,
            DrawingUnit::Cm => 10.0,
            DrawingUnit::M => 1000.0,
            DrawingUnit::In => 25.4,
            DrawingUnit::Pt => 25.4 / 72.0,
        }
    }
}

fn open(path: &Path) -> Result<BufReader<File>, Failure> {
    let file = File::open(path).map_err(|error| fault(path, error))?;
    let about = file.metadata().map_err(|error| fault(path, error))?;
    if !about.is_file() {
        return Err(fault(path, "not a regular file"));
    }
    if about.len() > MAX_BYTES {
        let size = about.len() >> 20;
        return Err(fault(path, format!("{size} MiB; drawings are read up to {} MiB", MAX_BYTES >> 20)));
    }
    Ok(BufReader::new(file))
}

/// What a file has that is not drawn, for messages.
pub fn skipped(drawing: &Drawing) -> String {
    drawing.skipped.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
