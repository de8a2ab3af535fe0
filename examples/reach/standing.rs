//! Where nozzle, plate or table should stand, with collisions: for an arm on a floor under a hanging nozzle, and for the workcells that we ship.

use super::Args;
use super::tried::{ALONG, TOOL_ANGLES, part};
use curvlay_examples::args::Failure;
use curvlay_kinematics::nalgebra::{Point3, Vector3};
use curvlay_kinematics::scene::{Body, Scene, Shape};
use curvlay_kinematics::workcell::{
    AnyWorkcell, ArmGeometry, ArmPart, ControllerModel, FrameModel, GrowingOptions, Held, MountModel, NozzleModel,
    PART, PLATE, PlateModel, ShapeModel, SolidModel, VERSION, Workcell, WorkcellModel, nozzle_pairs,
};
use curvlay_kinematics::{
    Arm, Assessment, BestFixturePlace, BestPosture, FixtureRegion, ReachOptions, Waypoint, best_fixture_place,
    reachable_points,
};
use std::cmp::Reverse;
use std::ops::ControlFlow;

/// The workcells that we ship.
pub const CELLS: [(&str, &str); 3] = [
    ("ur3", include_str!("../cells/ur3.json")),
    ("ur10", include_str!("../cells/ur10.json")),
    ("irb1200_table", include_str!("../cells/irb1200-table.json")),
];

/// Clearance from which a posture is not tight, beyond the margin.
const COMFORTABLE_MM: f64 = GrowingOptions::CLEARANCES_MM[0];
/// Nothing stands nearer to axis 1 than this, but above or below the arm: the feet of the arms here are up to 190 mm wide.
const FOOT_MM: f64 = 95.0;
/// Postures of the arm that say how far it reaches.
const BOUNDING_SAMPLES: usize = 2000;
/// Samples of tilt and turn of a table, besides the tool angles of an arm alone.
const TABLE_SAMPLES: [u32; 2] = [5, 12];
/// Tool angles of the search; reported places are judged with as many as in the dissertation.
const SEARCH_ANGLES: u32 = 12;

/// What stands still, and is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stands {
    Nozzle,
    Plate,
    Table,
}

impl Stands {
    fn of(model: &WorkcellModel) -> Self {
        match (model.held, &model.positioner) {
            (Held::Part, _) => Stands::Nozzle,
            (Held::Nozzle, None) => Stands::Plate,
            (Held::Nozzle, Some(_)) => Stands::Table,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Stands::Nozzle => "nozzle",
            Stands::Plate => "plate",
            Stands::Table => "table",
        }
    }
}

/// What a place is worth by all waypoints of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worth {
    pub place: Point3<f64>,
    /// Waypoints with a free posture.
    pub free: usize,
    /// Of these, those that keep less than the comfortable clearance.
    pub tight: usize,
    /// The smallest manipulability of the best postures, in mm^3.
    pub min_manipulability: f64,
}

impl Worth {
    /// The greater, the better.
    fn rank(&self) -> (usize, Reverse<usize>) {
        (self.free, Reverse(self.tight))
    }
}

/// The best place in a cell.
pub struct Stood {
    pub stands: Stands,
    pub best: Worth,
    /// Of a cell that we ship: where it stands.
    pub now: Option<Worth>,
    pub waypoints: usize,
    pub places: usize,
    pub assessments: u64,
    /// Coordinates along which the best place is at the end of what the arm reaches.
    pub at_end: [bool; 3],
}

impl Stood {
    /// How far a shipped cell is from its best; and how far if it were turned about axis 1, which changes little for an arm.
    pub fn apart_mm(&self) -> Option<[f64; 2]> {
        let best = self.best.place;
        self.now.map(|now| {
            let radius = |at: &Point3<f64>| at.x.hypot(at.y);
            let turned = (radius(&now.place) - radius(&best)).hypot(now.place.z - best.z);
            [(now.place - best).norm(), turned]
        })
    }

    /// What a shipped cell would gain at the best place, and why it stays where it is.
    pub fn verdict(&self) -> Option<String> {
        const KEPT: &str = "stays: the figures of the documentation were made there";
        let (now, all) = (self.now?, self.waypoints);
        Some(if now.free < self.best.free {
            format!("{} of {all} waypoints are free, {} at the best place; {KEPT}", now.free, self.best.free)
        } else if now.tight > self.best.tight {
            format!("as many are free, {} of them tight instead of {}; {KEPT}", now.tight, self.best.tight)
        } else if now.free == all && now.tight == 0 {
            let times = self.best.min_manipulability / now.min_manipulability;
            format!(
                "stays: all {all} waypoints are free with full clearance; the best place has {times:.1} times the smallest manipulability"
            )
        } else {
            format!("stays: no place is better by reach or clearance ({} of {all} free, {} tight)", now.free, now.tight)
        })
    }
}

/// An arm with the part in its hand on a floor, under a nozzle that hangs down.
pub fn bare_cell(arm: &str, platform_mm: f64) -> WorkcellModel {
    let solid = |name: &str, mount, shape| SolidModel { name: name.into(), mount, frame: FrameModel::default(), shape };
    WorkcellModel {
        version: VERSION,
        name: format!("{arm} on a floor under a hanging nozzle"),
        arm: ArmPart::new(ArmGeometry::Named(arm.into())),
        held: Held::Part,
        part: FrameModel { position_mm: [0.0, 0.0, platform_mm], ..FrameModel::default() },
        // Moved before anything is asked.
        nozzle: NozzleModel {
            tip_mm: [2.0 * FOOT_MM, 0.0, 2.0 * FOOT_MM],
            flow: [0.0, 0.0, -1.0],
            tip_flat_mm: 1.0,
            cone_half_angle_deg: 45.0,
            cone_height_mm: 8.0,
            block_diameter_mm: 20.0,
            block_top_mm: 61.0,
        },
        roller: None,
        plate: PlateModel { thickness_mm: 4.0, diameter_mm: None, size_mm: None },
        positioner: None,
        track: None,
        home_deg: None,
        controller: ControllerModel::default(),
        stand: None,
        solids: vec![
            solid(
                "floor",
                MountModel::Base,
                ShapeModel::Block { min_mm: [-2000.0, -2000.0, -60.0], max_mm: [2000.0, 2000.0, -10.0] },
            ),
            // What the nozzle hangs from.
            solid(
                "holder",
                MountModel::Nozzle,
                ShapeModel::Cylinder { radius_mm: 25.0, min_z_mm: 61.0, max_z_mm: 300.0 },
            ),
        ],
    }
}

/// The search in a cell: one that we ship, over all that its arm reaches, or an arm on a floor.
pub fn search(model: &WorkcellModel, is_shipped: bool, args: &Args) -> Result<Stood, Failure> {
    let cell = AnyWorkcell::new(model.clone())?;
    let stands = Stands::of(model);
    let now = standing_at(&cell)?;
    let region = region(&cell, is_shipped, args)?;
    let edge = 0.5 * args.box_mm;
    let few = part(edge, 3);
    let clear = plate_clearance(model, args.box_mm);
    let at = |place: &Point3<f64>| {
        let far = place.x.hypot(place.y);
        if far < clear {
            return None;
        }
        let cell = AnyWorkcell::new(moved(model, &(place - now))).ok()?;
        let rated = Rated::new(cell, edge, 3, SEARCH_ANGLES)?;
        Some(move |index: usize, waypoint: &Waypoint| rated.assess(index, waypoint))
    };
    let found = best_fixture_place(&region, &few, COMFORTABLE_MM, at, &|_| ControlFlow::Continue(()))?;
    let BestFixturePlace { place, places, assessments, at_end, .. } = found;
    let best = worth(model, place, args)?;
    let now = if is_shipped { Some(worth(model, now, args)?) } else { None };
    // The few waypoints and tool angles of the search may have missed that it is better where it stands.
    let best = now.filter(|now| now.rank() > best.rank()).unwrap_or(best);
    Ok(Stood { stands, best, now, waypoints: part(edge, ALONG).len(), places, assessments, at_end })
}

/// What a place is worth by all waypoints and tool angles.
pub fn worth(model: &WorkcellModel, place: Point3<f64>, args: &Args) -> Result<Worth, Failure> {
    let now = standing_at(&AnyWorkcell::new(model.clone())?)?;
    let cell = AnyWorkcell::new(moved(model, &(place - now)))?;
    let rated = Rated::new(cell, 0.5 * args.box_mm, ALONG, TOOL_ANGLES);
    Ok(rated.ok_or_else(|| Failure::new("the workcell makes no scene"))?.worth(place))
}

/// What must stay between axis 1 and what stands there.
fn plate_clearance(model: &WorkcellModel, wanted_mm: f64) -> f64 {
    match Stands::of(model) {
        Stands::Nozzle => FOOT_MM,
        Stands::Plate | Stands::Table => FOOT_MM + model.plate.diameter_mm.unwrap_or(wanted_mm) / 2.0,
    }
}

/// Where the nozzle's tip, or the middle of the plate, is in the base, at a table's zero.
fn standing_at(cell: &AnyWorkcell) -> Result<Point3<f64>, Failure> {
    let model = cell.equipment().model();
    Ok(match cell {
        AnyWorkcell::Six(_) if model.held == Held::Part => Point3::from(model.nozzle.tip_mm),
        AnyWorkcell::Six(_) | AnyWorkcell::Seven(_) => Point3::from(model.part.position_mm),
        AnyWorkcell::Eight(cell) => {
            let stance =
                cell.frames(&[0.0; 8]).ok_or_else(|| Failure::new("the table has no zero within its limits"))?;
            Point3::from(stance.part.translation.vector)
        }
    })
}

/// The cell with what stands still shifted.
fn moved(model: &WorkcellModel, shift: &Vector3<f64>) -> WorkcellModel {
    let mut model = model.clone();
    let place = match (&mut model.positioner, model.held) {
        (Some(positioner), _) => &mut positioner.frame.position_mm,
        (None, Held::Part) => &mut model.nozzle.tip_mm,
        (None, Held::Nozzle) => &mut model.part.position_mm,
    };
    *place = std::array::from_fn(|k| place[k] + shift[k]);
    model
}

/// The box of all that the arm reaches with what it holds. An arm on a floor turns all places about axis 1: one side is enough.
fn region(cell: &AnyWorkcell, is_shipped: bool, args: &Args) -> Result<FixtureRegion, Failure> {
    let equipment = cell.equipment();
    let held = match equipment.model().held {
        Held::Part => equipment.part_frame().1,
        Held::Nozzle => equipment.nozzle_frame().1,
    };
    let arm: Arm = *equipment.arm();
    let options = ReachOptions { samples: BOUNDING_SAMPLES, ..ReachOptions::default() };
    let points = reachable_points(&arm, &held, &options, |_, _| true)?;
    let ends = |k: usize| {
        points.iter().map(|point| point[k]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    let (mut min, mut max) = (Point3::origin(), Point3::origin());
    for k in 0..3 {
        (min[k], max[k]) = ends(k);
    }
    if !is_shipped {
        (min.x, min.y, max.y) = (0.0, 0.0, 0.0);
        min.z = min.z.max(0.0);
    }
    Ok(FixtureRegion { min, max, coarse_mm: args.coarse_mm, fine_mm: args.fine_mm })
}

/// A workcell with the part as built at each layer of waypoints.
struct Rated {
    cell: AnyWorkcell,
    scenes: Vec<Scene>,
    waypoints: Vec<Waypoint>,
    in_layer: usize,
    angles: u32,
}

impl Rated {
    fn new(cell: AnyWorkcell, edge: f64, along: usize, angles: u32) -> Option<Rated> {
        let equipment = cell.equipment();
        let (mount, frame) = equipment.part_frame();
        let mut scenes = vec![];
        for layer in 0..along {
            let mut model = equipment.scene(2.0 * edge);
            model.margin = GrowingOptions::MARGIN_MM;
            model.allowed = nozzle_pairs(&[PLATE]);
            let top = edge * layer as f64 / (along - 1) as f64;
            if layer > 0 {
                let corner = |k: usize| {
                    let side = |bit: usize| if k >> bit & 1 == 0 { -0.5 * edge } else { 0.5 * edge };
                    Point3::new(side(0), side(1), if k >> 2 & 1 == 0 { 0.0 } else { top })
                };
                let shape = Shape::Hull { points: (0..8).map(corner).collect(), radius: 0.0 };
                model.bodies.push(Body { name: PART.into(), mount, mount_body: frame, shape });
                // The part stands on the plate, and the hand that holds it does not touch it.
                model.allowed.extend(nozzle_pairs(&[PART]));
                model.allowed.push([PART.to_owned(), PLATE.to_owned()]);
            }
            scenes.push(Scene::new(model).ok()?);
        }
        let waypoints = part(edge, along);
        Some(Rated { cell, scenes, in_layer: along * along, waypoints, angles })
    }

    fn assess(&self, index: usize, waypoint: &Waypoint) -> Option<Assessment> {
        let scene = &self.scenes[index / self.in_layer];
        match &self.cell {
            AnyWorkcell::Six(cell) => {
                BestPosture::new(cell, scene, [self.angles], COMFORTABLE_MM).ok()?.assess(waypoint)
            }
            AnyWorkcell::Seven(cell) => {
                BestPosture::new(cell, scene, [self.angles], COMFORTABLE_MM).ok()?.assess(waypoint)
            }
            AnyWorkcell::Eight(cell) => {
                BestPosture::new(cell, scene, TABLE_SAMPLES, COMFORTABLE_MM).ok()?.assess(waypoint)
            }
        }
    }

    fn worth(&self, place: Point3<f64>) -> Worth {
        let found: Vec<Assessment> =
            self.waypoints.iter().enumerate().filter_map(|(index, waypoint)| self.assess(index, waypoint)).collect();
        let tight = found.iter().filter(|found| found.clearance < COMFORTABLE_MM).count();
        let least = found.iter().map(|found| found.quality).fold(f64::INFINITY, f64::min);
        Worth { place, free: found.len(), tight, min_manipulability: if found.is_empty() { 0.0 } else { least } }
    }
}
