//! What planning and checking a whole print ask of a workcell, by the scene of the workcell and the contacts of the tool paths.
//!
//! Two rules. The nozzle and its hot end against part and plate follow the rule of the machine file: a quarter of a layer
//! ([`Contacts`]), and nothing of the plate. Everything else keeps the margins of the [`GrowingScene`].

use curvlay_kinematics::workcell::{ClearanceLevel, Equipment, GrowingScene, NOZZLE, Workcell};
use curvlay_toolpath::deposit::{Deposition, PathSchedule};
use curvlay_toolpath::gouging::{self, ContactError, Contacts, Nozzle, NozzleError, NozzlePart, NozzleShape, Obstacle};
use curvlay_toolpath::orientation::{Pose, ToolPath};
use curvlay_trajectory::check::{Contact, GrowingPrintScene};
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::print::{Clearance, Moment, PrintOptions, PrintPath, PrintWorkcell, Waypoint};
use curvlay_trajectory::transfer::FreeSpace;
use nalgebra::Isometry3;

/// A workcell with the part as built so far.
#[derive(Clone)]
pub struct PrintingCell<'a, const N: usize, const F: usize, W> {
    scene: GrowingScene<'a, N, F, W>,
    contacts: Option<&'a Contacts<'a>>,
}

/// How deep the nozzle counts where that cannot be said, in millimetres: deeper than any part.
const UNKNOWN_MM: f64 = 1e6;

/// The waypoints of a tool path as planning of motions takes them.
pub fn waypoints(path: &ToolPath) -> Vec<Waypoint> {
    path.waypoints.iter().map(|waypoint| Waypoint { position: waypoint.position, axis: waypoint.axis }).collect()
}

/// The nozzle of a workcell as tool paths are planned with.
///
/// # Errors
/// [`NozzleError`] for one that these cannot have.
pub fn nozzle_of(equipment: &Equipment) -> Result<Nozzle, NozzleError> {
    let shape = &equipment.model().nozzle;
    Nozzle::new(NozzleShape {
        tip_flat_mm: shape.tip_flat_mm,
        half_angle: shape.cone_half_angle_deg.to_radians(),
        cone_height_mm: shape.cone_height_mm,
        block_mm: shape.block_diameter_mm,
    })
}

/// The paths of a print in the part frame, with the plan of what they lay when.
pub struct PlacedPaths {
    paths: Vec<(u32, Vec<Waypoint>, PathSchedule)>,
}

impl PlacedPaths {
    /// Of the paths of a plan and what is laid along them, with where the part stands.
    pub fn new(paths: &[ToolPath], deposition: &Deposition, frame_part: &Isometry3<f64>) -> Self {
        let paths = paths.iter().zip(deposition.schedules()).map(|(path, schedule)| {
            let waypoints = waypoints(path).iter().map(|waypoint| waypoint.moved(frame_part)).collect();
            (path.layer, waypoints, schedule)
        });
        PlacedPaths { paths: paths.collect() }
    }

    /// As planning takes them.
    pub fn paths(&self) -> Vec<PrintPath<'_>> {
        let paths = self.paths.iter().map(|(layer, waypoints, schedule)| PrintPath {
            layer: *layer,
            waypoints,
            times: schedule.times(),
            filament_mm: schedule.filament_mm(),
        });
        paths.collect()
    }
}

/// How postures are searched with a table: tilt and turn at fewer samples each than a tool angle alone.
pub fn table_options() -> PrintOptions<8, 2> {
    let (samples, dense_samples, near_samples) = ([5, 4], [25, 72], [7, 18]);
    PrintOptions { samples, dense_samples, near_samples, doublings: 1, ..PrintOptions::default() }
}

/// How postures are searched along a track: its places, since the tool angle is given.
pub fn track_options() -> PrintOptions<7, 1> {
    PrintOptions { samples: [25], dense_samples: [241], near_samples: [49], doublings: 3, ..PrintOptions::default() }
}

/// Two bodies in words.
fn named([a, b]: [&str; 2]) -> String {
    format!("{a} and {b}")
}

/// What a sweep has found, in words; what it cannot look at is not free.
fn swept<E: ToString>(found: Result<Option<[&str; 2]>, E>) -> Option<String> {
    found.map_or_else(|error| Some(error.to_string()), |bodies| bodies.map(named))
}

impl<'a, const N: usize, const F: usize, W: Workcell<N, F>> PrintingCell<'a, N, F, W> {
    /// A scene, and contacts that leave the plate to it.
    pub fn new(scene: GrowingScene<'a, N, F, W>, contacts: &'a Contacts<'a>) -> Self {
        PrintingCell { scene, contacts: Some(contacts) }
    }

    /// A scene alone: the tool may touch the part, and gouges in the plate only. For tools that press on what is built.
    pub fn pressing(scene: GrowingScene<'a, N, F, W>) -> Self {
        PrintingCell { scene, contacts: None }
    }

    /// The workcell.
    pub fn workcell(&self) -> &'a W {
        self.scene.workcell()
    }

    /// Adds a layer that is printed.
    ///
    /// # Errors
    /// Why it cannot be added, in words.
    pub fn begin_and_build(&mut self, layer: u32) -> Result<(), String> {
        PrintWorkcell::begin(self, layer)?;
        self.build(layer)
    }

    /// What touches at a posture while moving, in words; `None` where all is free.
    pub fn in_the_way(&self, joints: &[f64; N]) -> Option<String> {
        swept(self.scene.touching_moving(joints))
    }

    /// Where a nozzle over the part frame is in the part.
    fn in_part(&self, nozzle: &Waypoint) -> Pose {
        let frame_part = self.scene.frame_part();
        let tip = frame_part.inverse_transform_point(&nozzle.position);
        Pose { tip, direction: frame_part.inverse_transform_unit_vector(&nozzle.axis) }
    }

    /// Where a nozzle over the part frame is deepest in what is built at some moment, or in the plate, if that is deeper than it
    /// may be.
    fn deepest(&self, moment: Moment, nozzle: &Waypoint) -> Result<Option<gouging::Contact>, ContactError> {
        let pose = self.in_part(nozzle);
        let of_layers = match self.contacts {
            Some(contacts) => contacts.deepest(built(moment), &pose)?,
            None => None,
        };
        let equipment = self.scene.workcell().equipment();
        let of_plate = equipment.depth_in_plate(&nozzle.position, &nozzle.axis).map(|plate| {
            let part = if plate.body == NOZZLE { NozzlePart::Tip } else { NozzlePart::Block };
            gouging::Contact { obstacle: Obstacle::Plate, depth: plate.depth_mm, height: 0.0, part, point: pose.tip }
        });
        Ok(of_layers.into_iter().chain(of_plate).max_by(|a, b| a.depth.total_cmp(&b.depth)))
    }
}

/// A moment as contacts have it.
fn built(moment: Moment) -> gouging::Moment {
    match moment {
        Moment::At { path, waypoint } => gouging::Moment::At { path, waypoint },
        Moment::After { path } => gouging::Moment::After { path },
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> PrintWorkcell<N> for PrintingCell<'_, N, F, W> {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        self.scene.begin(layer).map_err(|error| error.to_string())
    }

    fn build(&mut self, layer: u32) -> Result<(), String> {
        self.scene.build(layer).map_err(|error| error.to_string())
    }

    fn keeps(&self, joints: &[f64; N], clearance: Clearance) -> bool {
        let level = match clearance {
            Clearance::Wide => ClearanceLevel::Wide,
            Clearance::Narrow => ClearanceLevel::Narrow,
            Clearance::Least => ClearanceLevel::Least,
        };
        matches!(self.scene.touching_printing(joints, level), Ok(None))
    }

    fn obstacle(&self, joints: &[f64; N]) -> Option<String> {
        self.scene.touching_printing(joints, ClearanceLevel::Least).ok()?.map(named)
    }

    fn touches(&self, control: &[[f64; N]; 4]) -> Option<String> {
        swept(self.scene.sweep_printing(control))
    }

    fn is_gouging(&self, moment: Moment, nozzle: &Waypoint) -> bool {
        let equipment = self.scene.workcell().equipment();
        let above_plate = equipment.depth_in_plate(&nozzle.position, &nozzle.axis).is_none();
        let is_free = |contacts: &Contacts| contacts.is_free(built(moment), &self.in_part(nozzle)).unwrap_or(false);
        !(above_plate && self.contacts.is_none_or(is_free))
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> GrowingPrintScene<N> for PrintingCell<'_, N, F, W> {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        PrintWorkcell::begin(self, layer)?;
        self.build(layer)
    }

    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.scene.workcell().nozzle_on_part(joints)
    }

    /// By the rule of the machine file. A question that has no answer is not "nowhere".
    fn contact(&self, moment: Moment, nozzle: &Waypoint) -> Option<Contact> {
        let (depth_mm, what) = match self.deepest(moment, nozzle) {
            Ok(found) => found.map(|found| (found.depth, format!("{} with its {}", found.obstacle, found.part)))?,
            Err(error) => (UNKNOWN_MM, error.to_string()),
        };
        Some(Contact { depth_mm, what })
    }

    fn sweep(&self, is_transfer: bool, control: &[[f64; N]; 4]) -> Option<String> {
        if is_transfer { swept(self.scene.sweep_moving(control)) } else { self.touches(control) }
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> FreeSpace<N> for PrintingCell<'_, N, F, W> {
    fn free(&self, from: &[f64; N], to: &[f64; N]) -> bool {
        matches!(self.scene.is_moving_free(from, to), Ok(true))
    }

    fn posture_free(&self, joints: &[f64; N]) -> bool {
        matches!(self.scene.touching_moving(joints), Ok(None))
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> CollisionIndicator<N> for PrintingCell<'_, N, F, W> {
    fn value(&self, joints: &[f64; N]) -> f64 {
        self.gradient(joints).0
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        self.scene.indicator(joints)
    }
}
