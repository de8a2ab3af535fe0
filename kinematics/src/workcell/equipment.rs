//! What stands in a workcell: the bodies of its scene, and the frames of part and nozzle.

use super::check::{self, Table, WorkcellError};
use super::controller::ProgramLanguage;
use super::links::{self, LinkBodies, LinkMeshReader};
use super::model::{ArmGeometry, Held, MountModel, RollerModel, WorkcellModel};
use super::solids::{body, foot, standing};
use crate::arm::robots::{self, CatalogueArm, Maker};
use crate::arm::{Arm, ArmModel};
use crate::positioner::Positioner;
use crate::scene::{Body, Mount, Posture, Scene, SceneModel, Shape};
use crate::track::Track;
use nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};

/// The body of the nozzle's cone in the scene.
pub const NOZZLE: &str = "nozzle";
/// The body of the block on top of the cone.
pub const HOT_END: &str = "hot end";
/// The body of the plate.
pub const PLATE: &str = "plate";
/// The body of the part, which the caller adds.
pub const PART: &str = "part";

/// Sides of the prism that stands for the cone, which it contains.
const SIDES: u32 = 12;

/// A plate as wide as this, in millimetres, stands for one whose diameter the print decides, where only checks need one.
const SOME_PLATE_MM: f64 = 100.0;

/// What is this near to a carriage wherever the track is, in millimetres, is what it runs on: motions keep a margin of about two.
const RUNS_ON_MM: f64 = 5.0;

/// A nozzle in the plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateContact {
    /// What of it is deepest: [`NOZZLE`] or [`HOT_END`].
    pub body: &'static str,
    /// How deep, in millimetres.
    pub depth_mm: f64,
}

/// The checked contents of a workcell, whatever its number of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Equipment {
    model: WorkcellModel,
    arm: Arm,
    arm_model: ArmModel,
    positioner: Option<Positioner>,
    track: Option<Track>,
    links: Vec<Body>,
    link_bodies: Option<LinkBodies>,
    /// Stand and solids.
    bodies: Vec<Body>,
    part: (Mount, Isometry3<f64>),
    nozzle: (Mount, Isometry3<f64>),
    /// The roller in the place of the nozzle, and its angle from the x axis of the nozzle frame to the direction of the tape.
    roller: Option<(RollerModel, f64)>,
}

impl Equipment {
    pub(super) fn new(model: WorkcellModel, read: LinkMeshReader<'_>) -> Result<(Self, Option<Table>), WorkcellError> {
        check::version(model.version)?;
        let (arm, arm_model) = check::arm(&model.arm)?;
        let table = model.positioner.as_ref().map(check::positioner).transpose()?;
        let track = model.track.as_ref().map(|track| check::track(track, &arm_model)).transpose()?;
        let (part, nozzle) = mounted(&model, table.is_some(), track.is_some())?;
        model.roller.as_ref().map_or(Ok(()), check::roller)?;
        check::plate(&model.plate)?;
        check_reach(&model, &arm_model, track.as_ref(), [&part.1, &nozzle.1])?;
        check::home(model.home_deg.as_deref(), arm.limits(), table.as_ref().map(|table| table.positioner.limits()))?;
        check::controller(&model.controller, &arm)?;
        let positioner = table.as_ref().map(|table| table.positioner);
        let (links, link_bodies) = links::of(&model.arm, &arm_model, read)?;
        let below = check::mount_below_base(&model.arm)?;
        let mut bodies = model.stand.map_or(Ok(vec![]), |stand| standing(&stand, foot(&links), below))?;
        for (index, solid) in model.solids.iter().enumerate() {
            bodies.push(body(
                &format!("solids[{index}]"),
                solid,
                (positioner.is_some(), track.is_some()),
                &part,
                &nozzle,
            )?);
        }
        let equipment = Equipment {
            arm,
            arm_model,
            positioner,
            track,
            links,
            link_bodies,
            bodies,
            part,
            nozzle,
            roller: None,
            model,
        };
        if equipment.model.controller.filament_group.is_some() && equipment.language() != Some(ProgramLanguage::Rapid) {
            return Err(WorkcellError::NoGroup);
        }
        equipment.check_names()?;
        Scene::new(equipment.scene(SOME_PLATE_MM))?;
        equipment.check_carriage()?;
        Ok((equipment, table))
    }

    /// Refuses a solid that the stand or the carriage of a track touches in the middle and at both ends of the range: it is what they run on.
    fn check_carriage(&self) -> Result<(), WorkcellError> {
        let Some(track) = self.track else { return Ok(()) };
        let [low, high] = [track.limits().lower[0], track.limits().upper[0]];
        let stands = self.bodies.len() - self.model.solids.len();
        for (index, solid) in self.model.solids.iter().enumerate().filter(|(_, solid)| solid.mount == MountModel::Base)
        {
            let carried = self.bodies.iter().filter(|body| body.mount == Mount::Base);
            let bodies = carried.chain([&self.bodies[stands + index]]).cloned().collect();
            let scene =
                Scene::new(SceneModel { bodies, track: Some(track), margin: RUNS_ON_MM, ..SceneModel::of(self.arm) })?;
            let touches = |place: f64| {
                let posture = Posture { joints: [0.0; 6], table: [place, 0.0] };
                matches!(scene.touching(&posture), Ok(Some(_)))
            };
            if [low, 0.0, high].into_iter().all(touches) {
                let what = format!(
                    "stand or carriage of the track touch `{}` wherever the track is; mount what they run on at `rail`",
                    solid.name
                );
                return Err(WorkcellError::Carriage { path: format!("solids[{index}].mount"), what });
            }
        }
        Ok(())
    }

    fn check_names(&self) -> Result<(), WorkcellError> {
        let wrong = |index: usize, what| {
            let name = self.model.solids[index].name.clone();
            WorkcellError::Name { path: format!("solids[{index}].name"), name, what }
        };
        let stands = self.bodies.len() - self.model.solids.len();
        for (index, solid) in self.model.solids.iter().enumerate() {
            let same = |body: &Body| body.name == solid.name;
            if solid.name.is_empty() {
                return Err(wrong(index, "is empty"));
            }
            let taken = [NOZZLE, HOT_END, PLATE, PART].contains(&solid.name.as_str())
                || self.links.iter().chain(&self.bodies[..stands]).any(same);
            if taken {
                return Err(wrong(index, "stands for another body of the workcell"));
            }
            if self.bodies[stands..stands + index].iter().any(same) {
                return Err(wrong(index, "is there twice"));
            }
        }
        Ok(())
    }

    /// The same with a roller in the place of the nozzle: it is the body [`NOZZLE`] of the scene, its block the body [`HOT_END`].
    ///
    /// # Arguments
    /// * `heading`: from the x axis of the nozzle frame to the direction of the tape, about the axis of the nozzle, in radians.
    ///
    /// # Errors
    /// [`WorkcellError`] names the field of `roller`.
    pub(super) fn with_roller(&self, roller: RollerModel, heading: f64) -> Result<Self, WorkcellError> {
        check::roller(&roller)?;
        let heading = check::finite("roller.mount_deg", heading.to_degrees())?.to_radians();
        Ok(Equipment { roller: Some((roller, heading)), ..self.clone() })
    }

    /// The roller in the place of the nozzle, and its heading in radians; `None` where the nozzle is there.
    pub fn roller(&self) -> Option<&(RollerModel, f64)> {
        self.roller.as_ref()
    }

    /// The numbers that the workcell was made from.
    pub fn model(&self) -> &WorkcellModel {
        &self.model
    }

    /// The home posture in radians, if the model names one: all `N` joints of the workcell, that of a track in its units.
    pub fn home<const N: usize>(&self) -> Option<[f64; N]> {
        let degrees = self.model.home_deg.as_ref()?;
        let on_track = self.track.as_ref().zip(self.model.track.as_ref());
        let place = on_track.map(|(track, part)| part.home_mm.map_or(0.0, |home_mm| track.joint(home_mm)));
        let joints: Vec<f64> = degrees.iter().map(|angle| angle.to_radians()).chain(place).collect();
        joints.try_into().ok()
    }

    /// The arm in the catalogue; `None` for one that is given by lengths.
    pub fn catalogue_arm(&self) -> Option<&'static CatalogueArm> {
        match &self.model.arm.geometry {
            ArmGeometry::Named(name) => robots::find(name),
            _ => None,
        }
    }

    /// What a report calls the workcell.
    pub fn name(&self) -> &str {
        &self.model.name
    }

    /// The numbers of the arm without its calibration, with the limits of the workcell.
    pub fn arm_model(&self) -> &ArmModel {
        &self.arm_model
    }

    /// The arm, within the limits of the workcell.
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// The language of its programs: the one that the workcell names, else that of the arm's maker; RAPID for an arm that is given by lengths and
    /// is not of the type of Universal Robots. `None` for an arm of a maker whose language is not written.
    pub fn language(&self) -> Option<ProgramLanguage> {
        let of_arm = match self.catalogue_arm().map(|arm| arm.maker) {
            None if !self.arm.is_ur() => Some(ProgramLanguage::Rapid),
            None | Some(Maker::UniversalRobots) => Some(ProgramLanguage::UrScript),
            Some(Maker::Abb) => Some(ProgramLanguage::Rapid),
            Some(Maker::Kuka) => Some(ProgramLanguage::Krl),
            Some(Maker::Fanuc) => Some(ProgramLanguage::Tp),
            Some(Maker::Staubli | Maker::Yaskawa) => None,
        };
        self.model().controller.language.or(of_arm)
    }

    /// Where the bodies of the links come from; `None` where the arm has none, and nothing can be said of what it touches.
    pub fn link_bodies(&self) -> Option<&LinkBodies> {
        self.link_bodies.as_ref()
    }

    /// The table, where there is one, within the limits of the workcell.
    pub fn positioner(&self) -> Option<&Positioner> {
        self.positioner.as_ref()
    }

    /// The track, where there is one.
    pub fn track(&self) -> Option<&Track> {
        self.track.as_ref()
    }

    /// What the part is fixed to, and the part frame there.
    pub fn part_frame(&self) -> (Mount, Isometry3<f64>) {
        self.part
    }

    /// What the nozzle is fixed to, and the nozzle frame there: origin at the tip, z up into the nozzle.
    pub fn nozzle_frame(&self) -> (Mount, Isometry3<f64>) {
        self.nozzle
    }

    /// The diameter of the plate, for a print that wants one of `wanted_mm`; of a rectangle its lesser edge.
    pub fn plate_diameter_mm(&self, wanted_mm: f64) -> f64 {
        let edge = self.model.plate.size_mm.map(|[x, y]| x.min(y));
        edge.or(self.model.plate.diameter_mm).unwrap_or(wanted_mm)
    }

    /// How deep a roller is in the plate at most, whatever its heading: by the end of its width where it leans across the tape, by its round where it
    /// leans along.
    fn roller_in_plate(roller: &RollerModel, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<PlateContact> {
        let lean = (1.0 - axis.z * axis.z).max(0.0).sqrt();
        let radius = 0.5 * roller.diameter_mm;
        // The middle of the roller, and what reaches down from it.
        let round = radius - axis.z * radius - tip.z;
        let end = 0.5 * roller.width_mm * lean - tip.z;
        let block = |height: f64| 0.5 * roller.block_diameter_mm * lean - tip.z - axis.z * height;
        let depths = [
            (NOZZLE, round + 0.5 * roller.width_mm * lean),
            (NOZZLE, end),
            (HOT_END, block(roller.diameter_mm)),
            (HOT_END, block(roller.block_top_mm)),
        ];
        let deepest = depths.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (body, depth_mm) = deepest;
        (depth_mm > 0.0 || depth_mm.is_nan()).then_some(PlateContact { body, depth_mm })
    }

    /// How deep the nozzle is in the plate, which has no edge here, and which of [`NOZZLE`] and [`HOT_END`] is deepest; `None` where
    /// it is above. The block ends at its top, so that the nozzle may lie flat; the edge of the cone is within the block.
    ///
    /// # Arguments
    /// * `tip`, `axis`: where the nozzle is in the part frame, in millimetres, the axis away from the tip. Numbers that are not
    ///   finite have a depth that is not a number.
    pub fn depth_in_plate(&self, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<PlateContact> {
        if let Some((roller, _)) = &self.roller {
            return Self::roller_in_plate(roller, tip, axis);
        }
        let nozzle = &self.model.nozzle;
        let lean = (1.0 - axis.z * axis.z).max(0.0).sqrt();
        let block_radius = 0.5 * nozzle.block_diameter_mm;
        let edges = [
            (NOZZLE, 0.0, 0.5 * nozzle.tip_flat_mm),
            (HOT_END, nozzle.cone_height_mm, block_radius),
            (HOT_END, nozzle.block_top_mm, block_radius),
        ];
        let depths = edges
            .map(|(body, height, radius)| PlateContact { body, depth_mm: radius * lean - tip.z - axis.z * height });
        let deepest = depths.into_iter().max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))?;
        (deepest.depth_mm > 0.0 || deepest.depth_mm.is_nan()).then_some(deepest)
    }

    /// The scene without the part: links, stand, solids, [`NOZZLE`], [`HOT_END`] and [`PLATE`], in this order. The plate has
    /// the diameter of the file, or `wanted_mm` if the file leaves it open. The margin is 0 and nothing is allowed to
    /// touch; set both as the motion in question needs it.
    pub fn scene(&self, wanted_mm: f64) -> SceneModel {
        let (tool, block) = self.tool_shapes();
        let low = -self.model.plate.thickness_mm;
        let plate = match self.model.plate.size_mm {
            Some([x, y]) => Shape::block(Point3::new(-x / 2.0, -y / 2.0, low), Point3::new(x / 2.0, y / 2.0, 0.0)),
            None => Shape::cylinder(self.plate_diameter_mm(wanted_mm) / 2.0, low, 0.0),
        };
        let body = |name: &str, (mount, mount_body), shape| Body { name: name.into(), mount, mount_body, shape };
        let mut bodies = self.bodies.clone();
        bodies.extend([
            body(NOZZLE, self.nozzle, tool),
            body(HOT_END, self.nozzle, block),
            body(PLATE, self.part, plate),
        ]);
        SceneModel {
            links: self.links.clone(),
            bodies,
            positioner: self.positioner,
            track: self.track,
            link_allowance: self.model.arm.allowance_mm,
            ..SceneModel::of(self.arm)
        }
    }

    /// Cone and block of the nozzle, or roller and block of the tape head, in the nozzle frame.
    fn tool_shapes(&self) -> (Shape, Shape) {
        if let Some((roller, heading)) = &self.roller {
            let (radius, half) = (roller.diameter_mm / 2.0, roller.width_mm / 2.0);
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *heading);
            // The ring about z becomes one about the axle, which lies across the tape.
            let ends = [-half, half]
                .into_iter()
                .flat_map(|y| ring(radius, 0.0).map(move |p| Point3::new(p.x, y, p.y + radius)));
            let points = ends.map(|point| turn * point).collect();
            let block = Shape::cylinder(roller.block_diameter_mm / 2.0, roller.diameter_mm, roller.block_top_mm);
            return (Shape::Hull { points, radius: 0.0 }, block);
        }
        let nozzle = &self.model.nozzle;
        let (height, flat) = (nozzle.cone_height_mm, nozzle.tip_flat_mm / 2.0);
        let wide = flat + height * nozzle.cone_half_angle_deg.to_radians().tan();
        let cone = Shape::Hull { points: ring(flat, 0.0).chain(ring(wide, height)).collect(), radius: 0.0 };
        let block = Shape::cylinder(nozzle.block_diameter_mm / 2.0, height, nozzle.block_top_mm);
        (cone, block)
    }
}

/// A frame on what it is fixed to.
type Mounted = (Mount, Isometry3<f64>);

/// What part and nozzle are fixed to, and their frames there.
fn mounted(model: &WorkcellModel, has_table: bool, has_track: bool) -> Result<(Mounted, Mounted), WorkcellError> {
    let [part, nozzle] = [check::frame("part", &model.part)?, check::nozzle(&model.nozzle)?];
    let ground = if has_track { Mount::Ground } else { Mount::Base };
    let hand = Mount::Link(6);
    match (model.held, has_table, has_track) {
        (_, true, true) => Err(WorkcellError::TrackAndTable),
        (Held::Part, false, true) => Err(WorkcellError::HeldPartOnTrack),
        (Held::Part, true, false) => Err(WorkcellError::HeldPartOnTable),
        (Held::Part, false, false) => Ok(((hand, part), (Mount::Base, nozzle))),
        (Held::Nozzle, false, _) => Ok(((ground, part), (hand, nozzle))),
        (Held::Nozzle, true, false) => Ok(((Mount::Table, part), (hand, nozzle))),
    }
}

/// Refuses an arm that is too short to bring part and nozzle together.
fn check_reach(
    model: &WorkcellModel,
    arm: &ArmModel,
    track: Option<&Track>,
    [part, nozzle]: [&Isometry3<f64>; 2],
) -> Result<(), WorkcellError> {
    let [to_part, to_tip] = [part, nozzle].map(|frame| frame.translation.vector.norm());
    let across = model.plate.size_mm.map(|[x, y]| x.hypot(y));
    let plate_mm = across.or(model.plate.diameter_mm).unwrap_or(SOME_PLATE_MM) / 2.0;
    match (model.held, &model.positioner, track) {
        (Held::Part, ..) => check::reach(arm, to_part, Some(("nozzle.tip_mm", to_tip))),
        (Held::Nozzle, Some(_), _) => check::reach(arm, to_tip, None),
        (Held::Nozzle, None, None) => check::reach(arm, to_tip, Some(("part", to_part - plate_mm))),
        (Held::Nozzle, None, Some(track)) => {
            let away_mm = check::beside_track(track, &part.translation.vector);
            check::reach(arm, to_tip, Some(("track.range_mm", away_mm - plate_mm)))
        }
    }
}

/// The corners of a prism around a circle about z.
fn ring(radius: f64, z: f64) -> impl Iterator<Item = Point3<f64>> {
    let out = radius / (PI / f64::from(SIDES)).cos();
    (0..SIDES).map(move |k| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
        Point3::new(out * cos, out * sin, z)
    })
}
