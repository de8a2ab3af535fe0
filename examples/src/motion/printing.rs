//! What planning and checking a whole print ask of a workcell, by the scene of the workcell and the contacts of the tool paths.
//!
//! Two rules. The nozzle and its hot end against part and plate follow the rule of the machine file: a quarter of a layer
//! ([`Contacts`]), and nothing of the plate. Everything else keeps the margins of the [`GrowingScene`].

use curvlay_kinematics::workcell::{ClearanceLevel, Equipment, GrowingScene, NOZZLE, Workcell};
use curvlay_toolpath::surface::{
    self, Contact, ContactError, Contacts, Deposition, Nozzle, NozzleError, NozzlePart, Obstacle, PathSchedule, Pose,
    ToolPath,
};
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::print::{Clearance, Moment, PrintCell, PrintOptions, PrintPath, Waypoint};
use curvlay_trajectory::transfer::FreeSpace;
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

/// A workcell with the part as far as it is built.
#[derive(Clone)]
pub struct PrintingCell<'a, const N: usize, const F: usize, W> {
    scene: GrowingScene<'a, N, F, W>,
    contacts: &'a Contacts<'a>,
}

/// A waypoint of a tool path in the part frame.
pub fn placed(waypoint: &surface::Waypoint, frame_part: &Isometry3<f64>) -> Waypoint {
    let axis = UnitVector3::new_unchecked(frame_part.rotation * waypoint.direction.into_inner());
    Waypoint { position: frame_part * waypoint.tip, axis }
}

/// The nozzle of a workcell as tool paths are planned with.
///
/// # Errors
/// [`NozzleError`] for one that these cannot have.
pub fn nozzle_of(equipment: &Equipment) -> Result<Nozzle, NozzleError> {
    let shape = &equipment.model().nozzle;
    let half_angle = shape.cone_half_angle_deg.to_radians();
    Nozzle::new(shape.tip_flat_mm, half_angle, shape.cone_height_mm, shape.block_diameter_mm)
}

/// Maps the part to the part frame so that the mean of its waypoints is in the middle of the plate.
pub fn in_the_middle(paths: &[ToolPath]) -> Isometry3<f64> {
    let tips = || paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| waypoint.tip.coords);
    let mean = tips().sum::<Vector3<f64>>() / tips().count().max(1) as f64;
    Isometry3::translation(-mean.x, -mean.y, 0.0)
}

/// The paths of a print in the part frame, with the plan of what they lay when.
pub struct PlacedPaths {
    paths: Vec<(u32, Vec<Waypoint>, PathSchedule)>,
}

impl PlacedPaths {
    /// Of the paths of a plan and what is laid along them, with where the part stands.
    pub fn new(paths: &[ToolPath], deposition: &Deposition, frame_part: &Isometry3<f64>) -> Self {
        let paths = paths.iter().zip(deposition.schedules()).map(|(path, schedule)| {
            let waypoints = path.waypoints.iter().map(|waypoint| placed(waypoint, frame_part)).collect();
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
        PrintingCell { scene, contacts }
    }

    /// Where the nozzle is in the part frame.
    pub fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.scene.workcell().nozzle_on_part(joints)
    }

    /// Maps the part to the part frame.
    pub fn frame_part(&self) -> &Isometry3<f64> {
        self.scene.frame_part()
    }

    /// What may touch on a cubic piece of a transfer, in words.
    pub fn touches_moving(&self, control: &[[f64; N]; 4]) -> Option<String> {
        swept(self.scene.sweep_moving(control))
    }

    /// Where a nozzle over the part frame is in the part.
    fn in_part(&self, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Pose {
        let frame_part = self.frame_part();
        let tip = frame_part.inverse_transform_point(tip);
        Pose { tip, direction: frame_part.inverse_transform_unit_vector(axis) }
    }

    /// Where a nozzle over the part frame is deepest in what is built at some moment, or in the plate, if that is deeper than it
    /// may be.
    ///
    /// # Errors
    /// A question that has no answer is not "nowhere".
    pub fn deepest(
        &self,
        moment: surface::Moment,
        tip: &Point3<f64>,
        axis: &UnitVector3<f64>,
    ) -> Result<Option<Contact>, ContactError> {
        let pose = self.in_part(tip, axis);
        let of_layers = self.contacts.deepest(moment, &pose)?;
        let of_plate = self.scene.workcell().equipment().depth_in_plate(tip, axis).map(|plate| {
            let part = if plate.body == NOZZLE { NozzlePart::Tip } else { NozzlePart::Block };
            Contact { obstacle: Obstacle::Plate, depth: plate.depth_mm, height: 0.0, part, point: pose.tip }
        });
        Ok(of_layers.into_iter().chain(of_plate).max_by(|a, b| a.depth.total_cmp(&b.depth)))
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> PrintCell<N> for PrintingCell<'_, N, F, W> {
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
        let moment = match moment {
            Moment::At { path, waypoint } => surface::Moment::At { path, waypoint },
            Moment::After { path } => surface::Moment::After { path },
        };
        let Waypoint { position, axis } = nozzle;
        let above_plate = self.scene.workcell().equipment().depth_in_plate(position, axis).is_none();
        !(above_plate && self.contacts.is_free(moment, &self.in_part(position, axis)).unwrap_or(false))
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
