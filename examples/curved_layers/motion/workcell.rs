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
use std::sync::Arc;

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

/// How far things stay apart at waypoints while the nozzle prints, in millimetres, the best first. With the first there is
/// room for the smooth motion to sway between two waypoints, and for the arm to leave. Each next one is for paths that cannot
/// be followed so: the last is just more than fine sweeps leave undecided.
pub const ROOMS_MM: [f64; 3] = [10.0, 3.0, 0.75];

/// How far the nozzle backs off before a transfer, in millimetres. From the first on it may not touch the part; up to there
/// all of the layer is in the scene, of cells as rough as the layer is thick.
const LIFTS_MM: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 80.0];

/// How a transfer is looked for, one way after the other: from near by, from far off, and both again with the tool turned
/// about the nozzle, which takes links of the arm out of the way. Then longer, too, and with shorter edges.
const EFFORTS: [Effort; 4] = {
    let near = Effort { far: false, turns: &[0.0], iterations: 500, step: 0.5 };
    let turned = Effort { turns: &[0.25, -0.25, 0.5, -0.5, 1.0, -1.0], iterations: 5000, step: 0.25, ..near };
    [near, Effort { far: true, ..near }, turned, Effort { far: true, ..turned }]
};

#[derive(Clone, Copy)]
struct Effort {
    /// Whether the farthest of the lifts is wanted that are free, not the nearest.
    far: bool,
    /// Radians, the first that is free.
    turns: &'static [f64],
    /// Random postures, and the longest edge in radians.
    iterations: usize,
    step: f64,
}

/// Transfers speed up and change their acceleration within these, in rad/s^2 and rad/s^3.
const ACCELERATION: f64 = 5.0;
const JERK: f64 = 50.0;

/// Robot, nozzle, plate and the part as far as it is built.
#[derive(Clone)]
pub struct Workcell<'a, const N: usize, const F: usize, R> {
    /// The nozzle may touch the part: that it does so only at its tip is what the check for gouging says.
    printing: Scene,
    /// The same for postures, which keep a distance that motions may use up: [`ROOMS_MM`].
    rooms: [Scene; ROOMS_MM.len()],
    /// Nothing may touch anything. One layer behind while transfers lead to the layer that is printed next.
    moving: Scene,
    robot: R,
    field: &'a FieldRun,
    /// Cells by the surface at which they are built, from 0.
    layers: Arc<[Vec<u32>]>,
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
        let [wide, aloof, close] = ROOMS_MM.map(with);
        let (printing, rooms) = (with(0.0)?, [wide?, aloof?, close?]);
        let moving = Scene::new(SceneModel { allowed: vec![], ..model }).map_err(failure)?;
        let bounds = Bounds { acceleration: [ACCELERATION; N], jerk: [JERK; N], ..robot.bounds(true) };
        Ok(Workcell {
            printing,
            rooms,
            moving,
            robot,
            field,
            layers: layers(field, surfaces).into(),
            begun: 0,
            built: 0,
            bounds,
        })
    }

    /// Adds the cells of all surfaces up to one, which is about to be printed.
    pub fn begin(&mut self, surface: u32) -> Result<(), Failure> {
        let (rows, until) = self.rows(self.begun, surface);
        for scene in self.rooms.iter_mut().chain([&mut self.printing]) {
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

    /// Whether a posture is free while the nozzle prints, with all of its layer there, and with this much room.
    pub fn may_print(&self, joints: &[f64; N], room: usize) -> bool {
        matches!(self.rooms[room].touching(&R::posture_of(joints)), Ok(None))
    }

    /// What is in the way at a posture, in words.
    pub fn in_the_way(&self, joints: &[f64; N]) -> Option<String> {
        let [a, b] = self.rooms[ROOMS_MM.len() - 1].touching(&R::posture_of(joints)).ok()??;
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
        let name = format!(
            "from path {} of layer {} to path {} of layer {}",
            from.path,
            from.layer + 1,
            to.path,
            to.layer + 1
        );
        let mut why = String::new();
        let mut tried = Vec::new();
        for effort in &EFFORTS {
            let lifted = [(&from.ends[1], &start), (&to.ends[0], &goal)].map(|(end, at)| self.lifted(end, at, effort));
            let [Some(above), Some(before)] = lifted else {
                let what = if lifted[0].is_none() { "back off" } else { "approach" };
                why = format!("transfer {name}: the nozzle cannot {what}");
                continue;
            };
            if tried.contains(&lifted) {
                continue;
            }
            tried.push(lifted);
            match self.way(&name, number, [&start, &above, &before, &goal], effort) {
                Ok(transfer) => return Ok(transfer),
                Err(error) => why = error,
            }
        }
        Err(why)
    }

    /// A free posture above the end of a run: along the nozzle, else half upright, else upright.
    fn lifted(&self, (free, waypoint): &([f64; F], Waypoint), end: &[f64; N], effort: &Effort) -> Option<[f64; N]> {
        let (axis, up) = (waypoint.axis.into_inner(), Vector3::z());
        // Straight down there is no half way.
        let ways = [axis, axis + up, up].into_iter().filter(|way| way.norm() > 1e-3);
        let mut lifts = LIFTS_MM;
        if effort.far {
            lifts.reverse();
        }
        let found = |turn: f64, way: Vector3<f64>, lift: f64| {
            let position = waypoint.position + way.normalize() * lift;
            let joints = self.robot.near(&Waypoint { position, ..*waypoint }, free, turn, end)?;
            let off = std::array::from_fn(|j| end[j] + (joints[j] - end[j]) * (LIFTS_MM[0] / lift));
            let is_free = self.posture_free(&joints)
                && sweep::<N, F, R>(&self.printing, end, &joints).is_none()
                && self.free(&off, &joints)
                && self.leads_off(end, &joints, &way);
            is_free.then_some(joints)
        };
        let along = |turn: f64, way: Vector3<f64>| lifts.iter().find_map(|&lift| found(turn, way, lift));
        effort.turns.iter().find_map(|&turn| ways.clone().find_map(|way| along(turn, way)))
    }

    /// Whether the tip goes off the part all along a motion that turns the tool: within 60 degrees of a way.
    fn leads_off(&self, from: &[f64; N], to: &[f64; N], way: &Vector3<f64>) -> bool {
        let tip = |share: f64| {
            let stance = self.robot.stance(&std::array::from_fn(|j| from[j] + (to[j] - from[j]) * share))?;
            Some(stance.part.inverse_transform_point(&stance.nozzle.translation.vector.into()))
        };
        let Some(start) = tip(0.0) else { return false };
        let off = |k: u32| tip(f64::from(k) / 8.0).map(|tip| tip - start);
        (1..=8).all(|k| off(k).is_some_and(|by| by.dot(way) >= 0.5 * by.norm() * way.norm()))
    }

    /// From an end over two free postures to the next.
    fn way(
        &self,
        name: &str,
        number: usize,
        [start, above, before, goal]: [&[f64; N]; 4],
        effort: &Effort,
    ) -> Result<Transfer<N>, String> {
        let Effort { iterations, step, .. } = *effort;
        let options =
            TransferOptions { seed: number as u64 + 1, iterations, step, shortcuts: 30, ..TransferOptions::default() };
        let told = |error: TransferError| error.to_string();
        let planned = plan_transfer(name, above, before, &self.bounds, self, &options).map_err(told)?;
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
