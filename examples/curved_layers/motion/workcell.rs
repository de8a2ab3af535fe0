//! The cell in which the robot moves: what touches along a motion, and ways from one motion to the next.

use super::{Run, robot};
use crate::failure;
use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, Sweep, links};
use curvlay_kinematics::{Cell, Waypoint, robots};
use curvlay_trajectory::transfer::{FreeSpace, Transfer, TransferOptions, plan_transfer};
use curvlay_trajectory::{Bounds, Trajectory};
use nalgebra::{Isometry3, Point3, Vector3};

/// The nozzle: a cone from its tip flat, a block above it; all in millimetres.
const TIP_RADIUS: f64 = 0.5;
const CONE_HEIGHT: f64 = 8.0;
const CONE_RADIUS: f64 = 8.5;
const BLOCK_RADIUS: f64 = 10.0;
const BLOCK_HEIGHT: f64 = 60.0;

/// What the part stands on.
const PLATE_MM: f64 = 4.0;

/// How fine sweeps look, in millimetres.
const RESOLUTION_MM: f64 = 2.0;

/// How far things stay apart at waypoints while the nozzle prints, in millimetres: more than sweeps leave undecided, and
/// than the smooth motion sways between two of them.
const ALOOF_MM: f64 = 3.0;

/// How far the nozzle backs off before a transfer, in millimetres: the first of these that clears the part.
const LIFTS_MM: [f64; 4] = [5.0, 10.0, 20.0, 40.0];

/// Transfers speed up and change their acceleration within these, in rad/s^2 and rad/s^3.
const ACCELERATION: f64 = 5.0;
const JERK: f64 = 50.0;

/// Robot, nozzle, plate and the part as far as it is built.
pub struct Workcell<'a> {
    /// The nozzle may touch the part: that it does so only at its tip is what the check for gouging says.
    printing: Scene,
    /// The same with the whole part: what is free there is free at any time. Two of them, since postures keep a distance
    /// that motions may use up.
    whole: Scene,
    whole_aloof: Scene,
    /// Nothing may touch anything.
    moving: Scene,
    cell: Cell,
    field: &'a FieldRun,
    /// Cells by the surface at which they are built, from 0.
    layers: Vec<Vec<u32>>,
    /// Surfaces that are built.
    built: usize,
    bounds: Bounds<6>,
}

impl<'a> Workcell<'a> {
    pub fn new(field: &'a FieldRun, surfaces: &SurfacesRun, shift: &Vector3<f64>) -> Result<Self, Failure> {
        let robot = robot(Vec::new())?;
        let cell = *robot.cell();
        let grid = &field.solid.grid;
        let flange_part = cell.held() * Isometry3::translation(-shift.x, -shift.y, 0.0);
        let body = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
        let ring = |radius: f64, z: f64| {
            (0..12).map(move |k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 12.0).sin_cos();
                Point3::new(radius * cos, radius * sin, z)
            })
        };
        let cone =
            Shape::Hull { points: ring(TIP_RADIUS, 0.0).chain(ring(CONE_RADIUS, CONE_HEIGHT)).collect(), radius: 0.0 };
        let block = Shape::cylinder(BLOCK_RADIUS, CONE_HEIGHT, BLOCK_HEIGHT);
        let nothing = vec![0; grid.rows().len()];
        let part = Shape::Cells { dims: grid.dims(), rows: nothing, cell: grid.cell_mm() };
        let origin = flange_part * Isometry3::from(nalgebra::Translation3::from(grid.origin().coords));
        let wide = field.platform_diameter_mm() / 2.0;
        let plate = Shape::cylinder(wide, -PLATE_MM, 0.0);
        let bodies = vec![
            body("nozzle", Mount::Base, cell.other(), cone),
            body("hot end", Mount::Base, cell.other(), block),
            body("part", Mount::Link(6), origin, part),
            body("plate", Mount::Link(6), flange_part, plate),
        ];
        let may = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        let model = SceneModel { links: links(&robots::UR3), bodies, ..SceneModel::of(*cell.arm()) };
        let allowed = vec![may("nozzle", "part"), may("hot end", "part"), may("nozzle", "plate")];
        let model = SceneModel { allowed, ..model };
        let aloof = SceneModel { margin: ALOOF_MM, ..model.clone() };
        let mut whole_aloof = Scene::new(aloof).map_err(failure)?;
        whole_aloof.add_cells("part", grid.rows()).map_err(failure)?;
        let printing = Scene::new(model.clone()).map_err(failure)?;
        let moving = Scene::new(SceneModel { allowed: vec![], ..model }).map_err(failure)?;
        let bounds = Bounds { acceleration: [ACCELERATION; 6], jerk: [JERK; 6], ..super::bounds(&robot) };
        let mut whole = printing.clone();
        whole.add_cells("part", grid.rows()).map_err(failure)?;
        Ok(Workcell {
            printing,
            whole,
            whole_aloof,
            moving,
            cell,
            field,
            layers: layers(field, surfaces),
            built: 0,
            bounds,
        })
    }

    /// Adds all cells that belong to the surfaces up to one.
    pub fn build_up_to(&mut self, surface: u32) -> Result<(), Failure> {
        let grid = &self.field.solid.grid;
        let until = (surface as usize + 1).min(self.layers.len());
        if self.built < until {
            let mut rows = vec![0u64; grid.rows().len()];
            let [nx, ny, _] = grid.dims().map(|n| n as usize);
            for &cell in self.layers[self.built..until].iter().flatten() {
                let [x, y, z] = grid.position(cell).map(|c| c as usize);
                rows[(y + ny * z) * nx.div_ceil(64) + x / 64] |= 1 << (x % 64);
            }
            self.printing.add_cells("part", &rows).map_err(failure)?;
            self.moving.add_cells("part", &rows).map_err(failure)?;
            self.built = until;
        }
        Ok(())
    }

    /// Whether a posture is free while the nozzle prints, however much of the part is there.
    pub fn may_print(&self, joints: &[f64; 6]) -> bool {
        matches!(self.whole_aloof.touching(&(*joints).into()), Ok(None))
    }

    /// Whether a motion is free while the nozzle prints, however much of the part is there.
    pub fn may_move(&self, trajectory: &Trajectory<6>) -> bool {
        let free = |pair: &[[f64; 6]]| {
            matches!(self.whole.sweep(&pair[0].into(), &pair[1].into(), RESOLUTION_MM), Ok(Sweep::Free))
        };
        trajectory.joints().windows(2).all(free)
    }

    /// What is not proven apart along a printing motion, a line for each step from knot to knot.
    pub fn collisions(&self, trajectory: &Trajectory<6>) -> Vec<String> {
        let step = |pair: &[[f64; 6]]| match self.printing.sweep(&pair[0].into(), &pair[1].into(), RESOLUTION_MM) {
            Ok(Sweep::Free) => None,
            Ok(Sweep::Near { bodies: [a, b], .. }) => Some(format!("{a} and {b}")),
            Err(error) => Some(error.to_string()),
        };
        trajectory.joints().windows(2).filter_map(step).collect()
    }

    /// A way from the end of one run to the start of the next.
    pub fn transfer(&self, number: usize, from: &Run, to: &Run) -> Option<Transfer<6>> {
        let (start, goal) = (*from.trajectory.joints().last()?, *to.trajectory.joints().first()?);
        let lifted = |(angle, waypoint): &(f64, Waypoint), near: &[f64; 6]| {
            LIFTS_MM.iter().find_map(|lift| {
                let position = waypoint.position + waypoint.axis.into_inner() * *lift;
                let flange = self.cell.flange(&Waypoint { position, ..*waypoint }, *angle);
                let joints = self.cell.arm().continuing(&flange, near)?;
                self.posture_free(&joints).then_some(joints)
            })
        };
        let (above, before) = (lifted(&from.ends[1], &start)?, lifted(&to.ends[0], &goal)?);
        let options =
            TransferOptions { seed: number as u64 + 1, iterations: 500, shortcuts: 30, ..TransferOptions::default() };
        let between =
            plan_transfer(&number.to_string(), &above, &before, &self.bounds, self, &options).ok()?.found()?;
        let corners = [start].into_iter().chain(between.corners().iter().copied()).chain([goal]).collect();
        Transfer::through(corners, &self.bounds).ok()
    }
}

/// The cells that each surface is the middle of. What comes after the last surface goes with it.
fn layers(field: &FieldRun, surfaces: &SurfacesRun) -> Vec<Vec<u32>> {
    let grid = &field.solid.grid;
    let mut layers = vec![Vec::new(); surfaces.sheets.len().max(1)];
    let last = layers.len() - 1;
    for cell in grid.iter() {
        if let Some(value) = surfaces.field.value(cell) {
            let height = value * surfaces.field.layer_cells() * grid.cell_mm();
            layers[((height / surfaces.height_mm) as usize).min(last)].push(cell);
        }
    }
    layers
}

impl FreeSpace<6> for Workcell<'_> {
    fn free(&self, from: &[f64; 6], to: &[f64; 6]) -> bool {
        matches!(self.moving.sweep(&(*from).into(), &(*to).into(), RESOLUTION_MM), Ok(Sweep::Free))
    }

    fn posture_free(&self, joints: &[f64; 6]) -> bool {
        matches!(self.moving.touching(&(*joints).into()), Ok(None))
    }
}
