//! The bodies of the links of a workcell's arm: those that are known of it, those of another arm, or meshes.

use super::check::{self, WorkcellError, finite, positive, wrong};
use super::model::{ArmGeometry, ArmPart, BodiesModel, LinkMeshModel};
use crate::arm::{ArmModel, Geometry};
use crate::scene::{self, Body, LINK_NAMES, LinkSource, MAX_COORDINATE, Shape, convex_pieces, link_body};
use nalgebra::{Isometry3, Point3};

/// Points and triangles of a mesh.
pub type LinkMesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// Reads a mesh by its name in the model, or says why that cannot be.
pub type LinkMeshReader<'a> = &'a mut dyn FnMut(&str) -> Result<LinkMesh, String>;

/// Lengths of an arm may differ by so much from those of the one whose bodies it has, in millimetres: more than any calibration
/// finds, less than any two arms differ by.
const MAX_DIFFERENCE_MM: f64 = 5.0;

/// What the bodies of an arm come from.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkBodies {
    /// What proofs are made for, in words.
    pub model: String,
    /// Whether the bodies were estimated from another arm.
    pub is_estimate: bool,
    /// How far the real body may stick out, as [`LinkSource::error_mm`]; of meshes of the user's 0, since they are the model.
    pub error_mm: f64,
}

impl LinkBodies {
    fn of(source: LinkSource, difference_mm: f64) -> Self {
        let LinkSource { arm, source, is_estimate, error_mm } = source;
        LinkBodies { model: format!("{arm}: {source}"), is_estimate, error_mm: error_mm + difference_mm }
    }
}

/// The bodies of an arm and what they come from; without bodies where nothing is known.
pub(super) fn of(
    part: &ArmPart,
    arm: &ArmModel,
    read: LinkMeshReader<'_>,
) -> Result<(Vec<Body>, Option<LinkBodies>), WorkcellError> {
    if !(0.0..=MAX_COORDINATE).contains(&part.allowance_mm) {
        return Err(wrong("arm.allowance_mm", part.allowance_mm, "from 0 to 1e6"));
    }
    // Bodies go with the frames of the arm as built; each is off by what its own two axes are.
    let moved_mm = match &part.calibration {
        None => 0.0,
        Some(calibration) => check::deviation(calibration)?.greatest_mm(longest_link(&arm.geometry)),
    };
    match &part.bodies {
        None => match (scene::link_source(arm), &part.geometry) {
            (Some(source), _) => Ok((scene::links(arm), Some(LinkBodies::of(source, moved_mm)))),
            (None, ArmGeometry::Named(_)) => estimated(part, arm, moved_mm),
            // Nobody has said what arm that is.
            (None, _) => Ok((vec![], None)),
        },
        Some(BodiesModel::Named(name)) => named(name, arm, moved_mm),
        Some(BodiesModel::Estimated) => estimated(part, arm, moved_mm),
        Some(BodiesModel::Meshes(meshes)) => meshed(meshes, read),
    }
}

fn longest_link(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Ur(table) => table.a[1].abs().max(table.a[2].abs()),
        Geometry::Ortho(lengths) => lengths.c2.abs().max(lengths.a2.hypot(lengths.c3)),
    }
}

/// How far real links stick out of tubes that are estimated from lengths, as a share of the length that tubes follow: `d5` of a UR arm (53 of 116 mm
/// on a UR10) and the upper arm of an ortho-parallel one (140 of 350 mm on an IRB 1200): see [`scene::estimated_links`].
const UR_ERROR: f64 = 0.46;
/// See [`UR_ERROR`].
const ORTHO_ERROR: f64 = 0.4;

/// The foot of an ortho-parallel arm ends at this share of the height of axis 2.
const FOOT_SHARE: f64 = 0.45;

/// Bodies from the lengths alone, for an arm of which no others are known: they keep an elbow out of a table, and prove nothing.
fn estimated(part: &ArmPart, arm: &ArmModel, moved_mm: f64) -> Result<(Vec<Body>, Option<LinkBodies>), WorkcellError> {
    let mut links = scene::estimated_links(arm);
    let below = check::mount_below_base(part)?;
    let error_mm = match &arm.geometry {
        Geometry::Ur(table) => UR_ERROR * table.d[4].abs(),
        Geometry::Ortho(lengths) => {
            if below > 0.0 {
                let top = FOOT_SHARE * (lengths.c1 + below) - below;
                links[0].shape = Shape::cylinder(0.3 * lengths.c2.abs(), (-below).min(top), top.max(-below));
            }
            ORTHO_ERROR * lengths.c2.abs()
        }
    };
    let model = "tubes from the lengths of the arm, thinner than its links".to_owned();
    Ok((links, Some(LinkBodies { model, is_estimate: true, error_mm: error_mm + moved_mm })))
}

/// The bodies of an arm by its name, on one of almost the same lengths.
fn named(name: &str, arm: &ArmModel, moved_mm: f64) -> Result<(Vec<Body>, Option<LinkBodies>), WorkcellError> {
    let path = "arm.bodies.named";
    let like = check::named_arm(path, name)?.model;
    let difference = difference(&like.geometry, &arm.geometry);
    if difference.is_nan() || difference > MAX_DIFFERENCE_MM {
        let must = format!("of an arm whose lengths differ from those of `{name}` by at most {MAX_DIFFERENCE_MM} mm");
        return Err(wrong(path, difference, must));
    }
    Ok((scene::links(&like), scene::link_source(&like).map(|source| LinkBodies::of(source, difference + moved_mm))))
}

/// The greatest difference of two lengths; infinite between arms of other kinds.
fn difference(a: &Geometry, b: &Geometry) -> f64 {
    let lengths = |geometry: &Geometry| match geometry {
        Geometry::Ur(table) => (0, [&table.d[..], &table.a[..]].concat()),
        Geometry::Ortho(lengths) => {
            (1, vec![lengths.a1, lengths.a2, lengths.b, lengths.c1, lengths.c2, lengths.c3, lengths.c4])
        }
    };
    let ((kind, a), (other, b)) = (lengths(a), lengths(b));
    if kind != other {
        return f64::INFINITY;
    }
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Bodies made of the hulls of the connected pieces of meshes.
fn meshed(
    meshes: &[LinkMeshModel],
    read: LinkMeshReader<'_>,
) -> Result<(Vec<Body>, Option<LinkBodies>), WorkcellError> {
    let mut pieces: [Vec<Shape>; 7] = Default::default();
    for (index, mesh) in meshes.iter().enumerate() {
        let path = format!("arm.bodies.meshes[{index}]");
        let Some(of_link) = pieces.get_mut(mesh.link) else {
            return Err(WorkcellError::Mount {
                path: format!("{path}.link"),
                what: "links are numbered from 0, the base, to 6",
            });
        };
        of_link.extend(hulls(&path, mesh, read)?);
    }
    if let Some(link) = pieces.iter().position(Vec::is_empty) {
        return Err(WorkcellError::NoLinkMesh { link, name: LINK_NAMES[link] });
    }
    let links = pieces.into_iter().enumerate().map(|(link, pieces)| link_body(link, pieces)).collect();
    let model = "convex hulls of the connected pieces of the link meshes of the workcell".to_owned();
    Ok((links, Some(LinkBodies { model, is_estimate: false, error_mm: 0.0 })))
}

/// The pieces of a mesh, in the frame of its link.
fn hulls(path: &str, mesh: &LinkMeshModel, read: LinkMeshReader<'_>) -> Result<Vec<Shape>, WorkcellError> {
    let bad = |what: String| WorkcellError::LinkMesh { path: format!("{path}.file"), file: mesh.file.clone(), what };
    let unit = positive(format!("{path}.unit_mm"), mesh.unit_mm)?;
    let link_mesh: Isometry3<f64> = check::frame(&format!("{path}.frame"), &mesh.frame)?;
    let (points, triangles) = read(&mesh.file).map_err(bad)?;
    let mut placed = Vec::with_capacity(points.len());
    for (k, point) in points.iter().enumerate() {
        let point = point * unit;
        if let Some(value) = point.iter().find(|value| value.is_nan() || value.abs() > MAX_COORDINATE) {
            finite(format!("{path}.file: vertex {k}"), *value)?;
        }
        placed.push(link_mesh * point);
    }
    let pieces = convex_pieces(&placed, &triangles).map_err(bad)?;
    Ok(pieces.into_iter().map(|points| Shape::Hull { points, radius: 0.0 }).collect())
}
