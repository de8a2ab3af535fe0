//! Writes a build: segments are measured, then written one after the other.

use super::layer;
use super::model::{self, Names};
use super::names::{MODEL_PART, layer_part};
use super::options::{BuildOptions, BuildWritten};
use super::package::Package;
use super::parts::Parts;
use super::profile::Measures;
use super::uuid::Content;
use super::{Segment, SegmentKind, WriteBuildError};
use crate::mesh::Mesh;
use nalgebra::Isometry3;
use std::io::{Seek, Write};

/// Writes mesh and segments as a 3MF package with a toolpath of six axes.
///
/// # Arguments
/// * `mesh`: the part, in mm, where the segments have it.
/// * `segments`: makes the same segments each time; it is called twice.
///
/// # Errors
/// [`WriteBuildError`]; what was written until then is half a file.
///
/// # Cost
/// `O(n)` for `n` triangles and lines; the memory of a segment and of four bytes a layer part. The bytes follow from the arguments alone.
///
/// # Example
/// ```
/// use curvlay_examples::build3mf::{BuildOptions, Line, Section, Segment, SegmentKind, frame_at, write_build};
/// use curvlay_examples::{mesh::Mesh, nalgebra::{Point3, Vector3}};
/// use curvlay_toolpath::path::BeadKind;
/// let at = |x| frame_at(Point3::new(x, 0.0, 0.3), Vector3::z_axis());
/// let bead = Some([Section { width_mm: 0.5, height_mm: 0.3 }; 2]);
/// let lines = vec![Line { end: at(10.0), bead, speed_mm_s: Some(20.0), seconds: 0.5 }];
/// let wall = SegmentKind::Bead(BeadKind::Wall);
/// let segment = Segment { layer: 0, path: 0, kind: wall, start: at(0.0), lines, filament_mm: 0.6, prime_mm: 0.0, retract_mm: 0.0 };
/// let vertices = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
/// let mesh = Mesh { vertices, triangles: vec![[0, 1, 2]] };
/// let mut file = std::io::Cursor::new(Vec::new());
/// let written = write_build(&mesh, || [segment.clone()].into_iter(), &BuildOptions { name: "bead", travels: true }, &mut file)?;
/// assert_eq!((written.parts, written.lines), (1, 1));
/// # Ok::<(), curvlay_examples::build3mf::WriteBuildError>(())
/// ```
pub fn write_build<I: Iterator<Item = Segment>>(
    mesh: &Mesh,
    segments: impl Fn() -> I,
    options: &BuildOptions,
    out: impl Write + Seek,
) -> Result<BuildWritten, WriteBuildError> {
    if mesh.triangles.is_empty() {
        return Err(WriteBuildError::NoMesh);
    }
    let first = measure(mesh, segments(), options)?;
    if first.layers.is_empty() {
        return Err(WriteBuildError::NoSegments);
    }
    let names = Names::new(first.content, &first.measures);
    let mut package = Package::begin(out, first.layers.len())?;
    package.part(MODEL_PART)?;
    model::write(mesh, &first.measures, &names, &first.layers, options, &mut package)?;
    let (mut content, mut parts, mut jump_s) = (of_mesh(mesh), Parts::default(), 0.0);
    let mut written = BuildWritten::default();
    for (index, segment) in segments().enumerate() {
        if !is_written(segment.kind, options) {
            jump_s += segment.lines.iter().map(|line| line.seconds).sum::<f64>();
            continue;
        }
        if parts.begins(&segment) {
            if written.parts > 0 {
                layer::close(&mut package)?;
            }
            package.part(&layer_part(written.parts))?;
            layer::open(&names.item, &names.profiles, &mut package)?;
            written.parts += 1;
        }
        layer::write(index, &segment, std::mem::take(&mut jump_s), &first.measures, &mut package)?;
        of_segment(&segment, &mut content);
        written.segments += 1;
        written.lines += segment.lines.len();
    }
    if content != first.content {
        return Err(WriteBuildError::Changed { segment: written.segments });
    }
    layer::close(&mut package)?;
    package.finish()?;
    Ok(written)
}

/// Whether a segment is written: beads are, travels if they are wanted.
fn is_written(kind: SegmentKind, options: &BuildOptions) -> bool {
    options.travels || kind != SegmentKind::Travel
}

/// What is known of the segments before they are written.
struct First {
    measures: Measures,
    /// The layer of each part.
    layers: Vec<u32>,
    content: Content,
}

fn measure(
    mesh: &Mesh,
    segments: impl Iterator<Item = Segment>,
    options: &BuildOptions,
) -> Result<First, WriteBuildError> {
    let mut first = First { measures: Measures::default(), layers: Vec::new(), content: of_mesh(mesh) };
    let mut parts = Parts::default();
    for (index, segment) in segments.enumerate().filter(|(_, segment)| is_written(segment.kind, options)) {
        first.measures.add(index, &segment)?;
        of_segment(&segment, &mut first.content);
        if parts.begins(&segment) {
            first.layers.push(segment.layer);
        }
    }
    Ok(first)
}

fn of_mesh(mesh: &Mesh) -> Content {
    let mut content = Content::new();
    mesh.vertices.iter().flat_map(|at| at.iter()).for_each(|value| content.number(*value));
    mesh.triangles.iter().flatten().for_each(|corner| content.add(&corner.to_le_bytes()));
    content
}

fn of_segment(segment: &Segment, content: &mut Content) {
    content.add(&segment.layer.to_le_bytes());
    content.add(&segment.path.to_le_bytes());
    content.add(super::names::name_of(segment.kind).unwrap_or_default().as_bytes());
    [segment.filament_mm, segment.prime_mm, segment.retract_mm].into_iter().for_each(|mm| content.number(mm));
    of_pose(&segment.start, content);
    for line in &segment.lines {
        of_pose(&line.end, content);
        content.number(line.seconds);
        content.number(line.speed_mm_s.unwrap_or(-1.0));
        for section in line.bead.into_iter().flatten() {
            content.number(section.width_mm);
            content.number(section.height_mm);
        }
    }
}

fn of_pose(pose: &Isometry3<f64>, content: &mut Content) {
    pose.translation.vector.iter().for_each(|value| content.number(*value));
    pose.rotation.coords.iter().for_each(|value| content.number(*value));
}
