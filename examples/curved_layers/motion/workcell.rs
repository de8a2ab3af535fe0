//! The cell in which the robot moves: what touches along a motion, and ways from one motion to the next.

use super::Run;
use super::robots::Printer;
use crate::failure;
use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::scene::{Body, Scene, SceneModel, Shape, Sweep};
use curvlay_trajectory::transfer::{FreeSpace, Transfer, TransferError, TransferOptions, plan_transfer};
use curvlay_trajectory::{Bounds, Trajectory};
use nalgebra::{Isometry3, Point3, Vector3};

/// The nozzle: a cone from its tip flat, a block above it; all in millimetres.
const TIP_RADIUS: f64 = 0.5;
const CONE_HEIGHT: f64 = 8.0;
const CONE_RADIUS: f64 = 8.5;
const BLOCK_RADIUS: f64 = 10.0;
const BLOCK_HEIGHT: f64 = 60.0;

/// What the part stands on.
pub const PLATE_MM: f64 = 4.0;

/// How fine sweeps look, in millimetres; and where that proves nothing.
const RESOLUTION_MM: f64 = 2.0;
const FINE_MM: f64 = 0.25;

/// How far things stay apart at waypoints while the nozzle prints, in millimetres: more than sweeps leave undecided, and
/// than the smooth motion sways between two of them.
const ALOOF_MM: f64 = 3.0;

/// The same for waypoints that no posture reaches so: more than fine sweeps leave undecided.
const CLOSE_MM: f64 = 0.75;

/// How far the nozzle backs off before a transfer, in millimetres: the first of these that clears the part, and where
/// that leads nowhere the last.
const LIFTS_MM: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 80.0];

/// Transfers speed up and change their acceleration within these, in rad/s^2 and rad/s^3.
const ACCELERATION: f64 = 5.0;
const JERK: f64 = 50.0;

/// Robot, nozzle, plate and the part as far as it is built.
pub struct Workcell<'a, const N: usize, const F: usize, R> {
    /// The nozzle may touch the part: that it does so only at its tip is what the check for gouging says.
    printing: Scene,
    /// The same for postures, which keep a distance that motions may use up.
    aloof: Scene,
    close: Scene,
    /// Nothing may touch anything. One layer behind while transfers lead to the layer that is printed next.
    moving: Scene,
    robot: R,
    field: &'a FieldRun,
    /// Cells by the surface at which they are built, from 0.
    layers: Vec<Vec<u32>>,
    /// Surfaces that are there while one is printed, that one included, and behind transfers.
    begun: usize,
    built: usize,
    bounds: Bounds<N>,
}

impl<'a, const N: usize, const F: usize, R: Printer<N, F>> Workcell<'a, N, F, R> {
    pub fn new(field: &'a FieldRun, surfaces: &SurfacesRun, shift: &Vector3<f64>) -> Result<Self, Failure> {
        let robot = R::empty()?;
        let grid = &field.solid.grid;
        let (carrier, part_frame) = robot.part_frame();
        let (holder, nozzle) = robot.nozzle();
        let carrier_part = part_frame * Isometry3::translation(-shift.x, -shift.y, 0.0);
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
        let origin = carrier_part * Isometry3::from(nalgebra::Translation3::from(grid.origin().coords));
        let wide = field.platform_diameter_mm() / 2.0;
        let plate = Shape::cylinder(wide, -PLATE_MM, 0.0);
        let mut model = robot.scene();
        model.bodies.extend([
            body("nozzle", holder, nozzle, cone),
            body("hot end", holder, nozzle, block),
            body("part", carrier, origin, part),
            body("plate", carrier, part_frame, plate),
        ]);
        let may = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        let allowed = vec![may("nozzle", "part"), may("hot end", "part"), may("nozzle", "plate")];
        let model = SceneModel { allowed, ..model };
        let with = |margin: f64| Scene::new(SceneModel { margin, ..model.clone() }).map_err(failure);
        let [printing, aloof, close] = [with(0.0)?, with(ALOOF_MM)?, with(CLOSE_MM)?];
        let moving = Scene::new(SceneModel { allowed: vec![], ..model }).map_err(failure)?;
        let bounds = Bounds { acceleration: [ACCELERATION; N], jerk: [JERK; N], ..robot.bounds(true) };
        Ok(Workcell {
            printing,
            aloof,
            close,
            moving,
            robot,
            field,
            layers: layers(field, surfaces),
            begun: 0,
            built: 0,
            bounds,
        })
    }

    /// Adds the cells of all surfaces up to one, which is about to be printed.
    pub fn begin(&mut self, surface: u32) -> Result<(), Failure> {
        let (rows, until) = self.rows(self.begun, surface);
        for scene in [&mut self.printing, &mut self.aloof, &mut self.close] {
            scene.add_cells("part", &rows).map_err(failure)?;
        }
        self.begun = until;
        Ok(())
    }

    /// The same for transfers, which from now on have that surface in their way.
    pub fn build(&mut self, surface: u32) -> Result<(), Failure> {
        let (rows, until) = self.rows(self.built, surface);
        self.moving.add_cells("part", &rows).map_err(failure)?;
        self.built = until;
        Ok(())
    }

    /// Cells of the surfaces from one up to another, and how many surfaces there are then.
    fn rows(&self, from: usize, surface: u32) -> (Vec<u64>, usize) {
        let grid = &self.field.solid.grid;
        let until = (surface as usize + 1).min(self.layers.len()).max(from);
        let mut rows = vec![0u64; grid.rows().len()];
        let [nx, ny, _] = grid.dims().map(|n| n as usize);
        for &cell in self.layers[from..until].iter().flatten() {
            let [x, y, z] = grid.position(cell).map(|c| c as usize);
            rows[(y + ny * z) * nx.div_ceil(64) + x / 64] |= 1 << (x % 64);
        }
        (rows, until)
    }

    /// Whether a posture is free while the nozzle prints, with all of its layer there; `close`: barely.
    pub fn may_print(&self, joints: &[f64; N], close: bool) -> bool {
        let scene = if close { &self.close } else { &self.aloof };
        matches!(scene.touching(&R::posture_of(joints)), Ok(None))
    }

    /// What is in the way at a posture, in words.
    pub fn in_the_way(&self, joints: &[f64; N]) -> Option<String> {
        let [a, b] = self.close.touching(&R::posture_of(joints)).ok()??;
        Some(format!("{a} and {b}"))
    }

    /// Whether a motion is free while the nozzle prints, with all of its layer there.
    pub fn may_move(&self, trajectory: &Trajectory<N>) -> bool {
        trajectory.joints().windows(2).all(|pair| sweep::<N, F, R>(&self.printing, &pair[0], &pair[1]).is_none())
    }

    /// What is not proven apart along a printing motion: the step from knot to knot, and the bodies.
    pub fn collisions(&self, trajectory: &Trajectory<N>) -> Vec<(usize, String)> {
        let near = |(step, pair): (usize, &[[f64; N]])| {
            sweep::<N, F, R>(&self.printing, &pair[0], &pair[1]).map(|near| (step, near))
        };
        trajectory.joints().windows(2).enumerate().filter_map(near).collect()
    }

    /// A way from the end of one run to the start of the next, or why there is none.
    pub fn transfer(&self, number: usize, from: &Run<N, F>, to: &Run<N, F>) -> Result<Transfer<N>, String> {
        let (before, after) = (from.trajectory.joints(), to.trajectory.joints());
        let (start, goal) = (before[before.len() - 1], after[0]);
        let (leave, reach) = (self.lifted(&from.ends[1], &start), self.lifted(&to.ends[0], &goal));
        // Near by first; where that leads nowhere from far off.
        let [Some(above), Some(before)] = [leave.first(), reach.first()] else {
            return Err(
                if leave.is_empty() { "the nozzle cannot back off" } else { "the nozzle cannot approach" }.into()
            );
        };
        self.way(number, [&start, above, before, &goal]).or_else(|why| match (leave.last(), reach.last()) {
            (Some(far), Some(off)) if leave.len().max(reach.len()) > 1 => self.way(number, [&start, far, off, &goal]),
            _ => Err(why),
        })
    }

    /// Free postures above the end of a run, the nearest first: along the nozzle, else half upright, else upright.
    fn lifted(&self, (free, waypoint): &([f64; F], Waypoint), end: &[f64; N]) -> Vec<[f64; N]> {
        let (axis, up) = (waypoint.axis.into_inner(), Vector3::z());
        let along = |direction: Vector3<f64>| -> Vec<[f64; N]> {
            let direction = direction.normalize();
            let at = |lift: &f64| {
                let position = waypoint.position + direction * *lift;
                let joints = self.robot.near(&Waypoint { position, ..*waypoint }, free, end)?;
                let is_free = self.posture_free(&joints) && sweep::<N, F, R>(&self.printing, end, &joints).is_none();
                is_free.then_some(joints)
            };
            LIFTS_MM.iter().filter_map(at).collect()
        };
        // Straight down there is no half way.
        let ways = [axis, axis + up, up].into_iter().filter(|way| way.norm() > 1e-3);
        ways.map(along).find(|found| !found.is_empty()).unwrap_or_default()
    }

    /// From an end over two free postures to the next.
    fn way(&self, number: usize, [start, above, before, goal]: [&[f64; N]; 4]) -> Result<Transfer<N>, String> {
        let options =
            TransferOptions { seed: number as u64 + 1, iterations: 500, shortcuts: 30, ..TransferOptions::default() };
        let told = |error: TransferError| error.to_string();
        let planned = plan_transfer(&number.to_string(), above, before, &self.bounds, self, &options).map_err(told)?;
        let why = planned.to_string();
        let between = planned.found().ok_or(why)?;
        let corners = [*start].into_iter().chain(between.corners().iter().copied()).chain([*goal]).collect();
        Transfer::through(corners, &self.bounds).map_err(told)
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

impl<const N: usize, const F: usize, R: Printer<N, F>> FreeSpace<N> for Workcell<'_, N, F, R> {
    fn free(&self, from: &[f64; N], to: &[f64; N]) -> bool {
        let [from, to] = [from, to].map(R::posture_of);
        matches!(self.moving.is_free(&from, &to, RESOLUTION_MM), Ok(true))
    }

    fn posture_free(&self, joints: &[f64; N]) -> bool {
        matches!(self.moving.touching(&R::posture_of(joints)), Ok(None))
    }
}

/// What is not proven apart on the way from one posture to another, in words.
fn sweep<const N: usize, const F: usize, R: Printer<N, F>>(
    scene: &Scene,
    from: &[f64; N],
    to: &[f64; N],
) -> Option<String> {
    let looked = |resolution| match scene.sweep(&R::posture_of(from), &R::posture_of(to), resolution) {
        Ok(Sweep::Free) => None,
        Ok(Sweep::Near { bodies: [a, b], .. }) => Some(format!("{a} and {b}")),
        Err(error) => Some(error.to_string()),
    };
    looked(RESOLUTION_MM).and_then(|_| looked(FINE_MM))
}
