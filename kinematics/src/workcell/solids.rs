//! Stand and solids of a workcell: the bodies of their models.

use super::check::{self, WorkcellError, each, finite, positive};
use super::model::{MountModel, ShapeModel, SolidModel, StandModel};
use crate::scene::{Body, Mount, Shape};
use nalgebra::{Isometry3, Point3};

/// The radius of the foot of an arm without bodies, in millimetres.
const UNKNOWN_FOOT_MM: f64 = 75.0;

/// The radius of an arm's foot: half of its lesser width, so that a plug at its side does not count.
pub(super) fn foot(links: &[Body]) -> f64 {
    fn points(shape: &Shape) -> Vec<Point3<f64>> {
        match shape {
            Shape::Hull { points, .. } => points.clone(),
            Shape::Union(shapes) => shapes.iter().flat_map(points).collect(),
            Shape::Capsule { .. } | Shape::Mesh { .. } | Shape::Cells { .. } => vec![],
        }
    }
    let points = links.first().map_or(vec![], |body| points(&body.shape));
    let width = |of: fn(&Point3<f64>) -> f64| points.iter().map(|point| of(point).abs()).fold(0.0, f64::max);
    let radius = width(|point| point.x).min(width(|point| point.y));
    if radius > 0.0 { radius } else { UNKNOWN_FOOT_MM }
}

/// What the arm stands on, whose top is `below` the base frame.
pub(super) fn standing(stand: &StandModel, foot: f64, below: f64) -> Result<Vec<Body>, WorkcellError> {
    let top = Isometry3::translation(0.0, 0.0, -below);
    let body = |name: &str, shape| Body { name: name.into(), mount: Mount::Base, mount_body: top, shape };
    let block = |low: [f64; 3], high: [f64; 3]| Shape::block(low.into(), high.into());
    match *stand {
        StandModel::Pedestal { height_mm, radius_mm } => {
            let height = positive("stand.pedestal.height_mm", height_mm)?;
            let radius = radius_mm.map_or(Ok(foot), |radius| positive("stand.pedestal.radius_mm", radius))?;
            Ok(vec![body("pedestal", Shape::cylinder(radius, -height, 0.0))])
        }
        StandModel::Beam { height_mm, thickness_mm, length_mm, half_width_mm, pillar_mm } => {
            let height = positive("stand.beam.height_mm", height_mm)?;
            let thick = positive("stand.beam.thickness_mm", thickness_mm)?;
            let behind = positive("stand.beam.length_mm", length_mm)?;
            let half = half_width_mm.map_or(Ok(foot), |half| positive("stand.beam.half_width_mm", half))?;
            let along = positive("stand.beam.pillar_mm[0]", pillar_mm[0])?;
            let across = positive("stand.beam.pillar_mm[1]", pillar_mm[1])?;
            if thick > height {
                let must = format!("at most the height of the pillar, {height}");
                return Err(check::wrong("stand.beam.thickness_mm", thick, must));
            }
            Ok(vec![
                body("beam", block([-behind, -half, -thick], [half, half, 0.0])),
                body("pillar", block([-behind - along, -across / 2.0, -height], [-behind, across / 2.0, 0.0])),
            ])
        }
    }
}

/// The body of a solid.
pub(super) fn body(
    path: &str,
    solid: &SolidModel,
    (has_table, has_track): (bool, bool),
    part: &(Mount, Isometry3<f64>),
    nozzle: &(Mount, Isometry3<f64>),
) -> Result<Body, WorkcellError> {
    let no_place = |what| WorkcellError::Mount { path: format!("{path}.mount"), what };
    let (mount, mount_frame) = match solid.mount {
        MountModel::Base if has_track => (Mount::Ground, Isometry3::identity()),
        MountModel::Carriage | MountModel::Rail if !has_track => return Err(no_place("the workcell has no track")),
        MountModel::Base | MountModel::Carriage => (Mount::Base, Isometry3::identity()),
        MountModel::Rail => (Mount::Rail, Isometry3::identity()),
        MountModel::Link(link) if (1..=6).contains(&link) => (Mount::Link(link), Isometry3::identity()),
        MountModel::Link(_) => return Err(no_place("links are numbered from 1 to 6")),
        MountModel::Flange => (Mount::Link(6), Isometry3::identity()),
        MountModel::Tilt | MountModel::Table if !has_table => return Err(no_place("the workcell has no positioner")),
        MountModel::Tilt => (Mount::Tilt, Isometry3::identity()),
        MountModel::Table => (Mount::Table, Isometry3::identity()),
        MountModel::Part => *part,
        MountModel::Nozzle => *nozzle,
    };
    let mount_body = mount_frame * check::frame(&format!("{path}.frame"), &solid.frame)?;
    let shape = shape(&format!("{path}.shape"), &solid.shape)?;
    Ok(Body { name: solid.name.clone(), mount, mount_body, shape })
}

fn shape(path: &str, shape: &ShapeModel) -> Result<Shape, WorkcellError> {
    match shape {
        ShapeModel::Block { min_mm, max_mm } => {
            let path = format!("{path}.block");
            let min = each(&format!("{path}.min_mm"), min_mm)?;
            let max = each(&format!("{path}.max_mm"), max_mm)?;
            for axis in 0..3 {
                if min[axis] > max[axis] {
                    let must = format!("at most max_mm[{axis}], {}", max[axis]);
                    return Err(check::wrong(format!("{path}.min_mm[{axis}]"), min[axis], must));
                }
            }
            Ok(Shape::block(min.into(), max.into()))
        }
        ShapeModel::Cylinder { radius_mm, min_z_mm, max_z_mm } => {
            let path = format!("{path}.cylinder");
            let radius = positive(format!("{path}.radius_mm"), *radius_mm)?;
            let min = finite(format!("{path}.min_z_mm"), *min_z_mm)?;
            let max = finite(format!("{path}.max_z_mm"), *max_z_mm)?;
            if min > max {
                return Err(check::wrong(format!("{path}.min_z_mm"), min, format!("at most max_z_mm, {max}")));
            }
            Ok(Shape::cylinder(radius, min, max))
        }
        ShapeModel::Capsule { from_mm, to_mm, radius_mm } => {
            let path = format!("{path}.capsule");
            let from = each(&format!("{path}.from_mm"), from_mm)?.into();
            let to = each(&format!("{path}.to_mm"), to_mm)?.into();
            Ok(Shape::Capsule { from, to, radius: positive(format!("{path}.radius_mm"), *radius_mm)? })
        }
        ShapeModel::Hull { points_mm } => {
            let path = format!("{path}.hull.points_mm");
            let points = points_mm.iter().enumerate().map(|(k, point)| each(&format!("{path}[{k}]"), point));
            let points: Result<Vec<[f64; 3]>, WorkcellError> = points.collect();
            Ok(Shape::Hull { points: points?.into_iter().map(Point3::from).collect(), radius: 0.0 })
        }
    }
}
