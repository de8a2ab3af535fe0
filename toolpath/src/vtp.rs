//! Tool paths for ParaView: VTK XML, polygonal data with raw binary arrays (`.vtp`).
//!
//! Takes tool paths and the moves of a [`Deposition`](crate::deposit::Deposition); writes a file ([`write_paths_vtp`]).
//!
//! A line for each path; at its points `width_mm`, `height_mm`, `direction`, `time_s` (when the nozzle is there) and `kind` (0 wall, 1 solid,
//! 2 skin, 3 infill, 4 bridge, 5 support), for each line `layer` (from 1). Numbers are of single precision: 41 bytes a waypoint.

use crate::deposit::{Move, MoveKind};
use crate::orientation::ToolPath;
use crate::path::BeadKind;
use std::io::{self, BufWriter, Write};

/// Writes paths as they are printed.
///
/// # Arguments
/// * `paths`, and the `moves` of the [`Deposition`](crate::deposit::Deposition) that lays them, for the times; without moves all times are 0.
///
/// # Errors
/// What the system says; `InvalidInput` for more than 2^31 waypoints.
///
/// # Cost
/// `O(n)` for `n` waypoints, 4 bytes of memory each.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// use curvlay_toolpath::vtp::write_paths_vtp;
/// let (axis, kind) = (Vector3::z_axis(), BeadKind::Wall);
/// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.3), axis, width: 0.5, height: 0.3, arc: x, added: false, lift: Vector3::zeros(), kind };
/// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0)] };
/// let mut file = Vec::new();
/// write_paths_vtp(&[path], &[], &mut file)?;
/// assert!(String::from_utf8_lossy(&file).contains("NumberOfPoints=\"2\" NumberOfVerts=\"0\" NumberOfLines=\"1\""));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_paths_vtp(paths: &[ToolPath], moves: &[Move], out: impl Write) -> io::Result<()> {
    let points: usize = paths.iter().map(|path| path.waypoints.len()).sum();
    if i32::try_from(points).is_err() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "more than 2^31 waypoints"));
    }
    let times = times(paths, moves);
    let groups = groups(paths, points, &times);
    let mut out = BufWriter::new(out);
    write!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <PolyData>\n<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n",
        paths.len()
    )?;
    declare(&groups, &mut out)?;
    write!(out, "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
    // In the order in which they are declared: the offsets there count on it.
    for array in groups.iter().flat_map(|(_, arrays)| arrays) {
        out.write_all(&(array.bytes() as u64).to_le_bytes())?;
        (array.fill)(&mut out)?;
    }
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    out.flush()
}

/// The arrays of the file, by the elements that hold them.
fn groups<'a>(paths: &'a [ToolPath], points: usize, times: &'a [f32]) -> [(&'static str, Vec<Array<'a>>); 4] {
    let waypoints = move || paths.iter().flat_map(|path| &path.waypoints);
    let ends = move || {
        paths.iter().scan(0, |end, path| {
            *end += path.waypoints.len() as i32;
            Some(*end)
        })
    };
    [
        (
            "PointData",
            vec![
                Array::new("width_mm", FLOAT, 1, points, move |out| floats(waypoints().map(|w| w.width), out)),
                Array::new("height_mm", FLOAT, 1, points, move |out| floats(waypoints().map(|w| w.height), out)),
                Array::new("direction", FLOAT, 3, points, move |out| {
                    floats(waypoints().flat_map(|w| [w.axis.x, w.axis.y, w.axis.z]), out)
                }),
                Array::new("time_s", FLOAT, 1, points, move |out| {
                    bytes(times.iter().map(|time| time.to_le_bytes()), out)
                }),
                Array::new("kind", ("UInt8", 1), 1, points, move |out| {
                    bytes(waypoints().map(|w| [number(w.kind)]), out)
                }),
            ],
        ),
        (
            "CellData",
            vec![Array::new("layer", ("UInt32", 4), 1, paths.len(), move |out| {
                bytes(paths.iter().map(|path| path.layer.saturating_add(1).to_le_bytes()), out)
            })],
        ),
        (
            "Points",
            vec![Array::new("points", FLOAT, 3, points, move |out| {
                floats(waypoints().flat_map(|w| [w.position.x, w.position.y, w.position.z]), out)
            })],
        ),
        (
            "Lines",
            vec![
                Array::new("connectivity", INT, 1, points, move |out| {
                    bytes((0..points as i32).map(i32::to_le_bytes), out)
                }),
                Array::new("offsets", INT, 1, paths.len(), move |out| bytes(ends().map(i32::to_le_bytes), out)),
            ],
        ),
    ]
}

/// Names and types of all arrays, and where in the appended data each begins.
fn declare(groups: &[(&str, Vec<Array>)], out: &mut impl Write) -> io::Result<()> {
    let mut offset = 0;
    for (group, arrays) in groups {
        writeln!(out, "<{group}>")?;
        for array in arrays {
            let Array { name, of: (kind, _), components, .. } = array;
            write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"")?;
            writeln!(out, " format=\"appended\" offset=\"{offset}\"/>")?;
            offset += HEADER + array.bytes();
        }
        writeln!(out, "</{group}>")?;
    }
    Ok(())
}

/// Types of arrays, with the bytes of a number.
const FLOAT: (&str, usize) = ("Float32", 4);
const INT: (&str, usize) = ("Int32", 4);

/// Bytes before each array: its length.
const HEADER: usize = 8;

type Fill<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// An array of the file, and what writes its numbers.
struct Array<'a> {
    name: &'static str,
    of: (&'static str, usize),
    components: usize,
    tuples: usize,
    fill: Fill<'a>,
}

impl<'a> Array<'a> {
    fn new(
        name: &'static str,
        of: (&'static str, usize),
        components: usize,
        tuples: usize,
        fill: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Self {
        Array { name, of, components, tuples, fill: Box::new(fill) }
    }

    fn bytes(&self) -> usize {
        self.of.1 * self.components * self.tuples
    }
}

fn bytes<const N: usize>(mut items: impl Iterator<Item = [u8; N]>, out: &mut dyn Write) -> io::Result<()> {
    items.try_for_each(|item| out.write_all(&item))
}

fn floats(numbers: impl Iterator<Item = f64>, out: &mut dyn Write) -> io::Result<()> {
    bytes(numbers.map(|number| (number as f32).to_le_bytes()), out)
}

fn number(kind: BeadKind) -> u8 {
    match kind {
        BeadKind::Wall => 0,
        BeadKind::Solid => 1,
        BeadKind::Skin => 2,
        BeadKind::Infill => 3,
        BeadKind::Bridge => 4,
        BeadKind::Support => 5,
        BeadKind::SparseSupport => 6,
        BeadKind::SupportBridge => 7,
    }
}

/// When the nozzle is at each waypoint, path by path, in seconds since the first move began.
fn times(paths: &[ToolPath], moves: &[Move]) -> Vec<f32> {
    let mut starts = vec![0];
    starts.extend(paths.iter().scan(0, |end, path| {
        *end += path.waypoints.len();
        Some(*end)
    }));
    let mut times = vec![0.0; starts[paths.len()]];
    let mut now = 0.0;
    for step in moves {
        let before = now;
        now += step.seconds;
        if step.kind != MoveKind::Print || step.path >= paths.len() {
            continue;
        }
        let at = starts[step.path] + step.waypoint;
        if let Some(time) = times.get_mut(at).filter(|_| at < starts[step.path + 1]) {
            *time = now as f32;
        }
        if step.waypoint == 1 {
            times[starts[step.path]] = before as f32;
        }
    }
    times
}
