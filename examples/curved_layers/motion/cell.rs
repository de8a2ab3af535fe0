//! The workcell with the part as far as it is built: what touches along a motion.
//!
//! Two rules. The nozzle and its block against part and plate follow the rule of the machine file ([`Contacts`]): a quarter of a
//! layer, everywhere on a motion. Everything else (links, table, plate, stand, and the part against these) keeps a margin, and
//! on transfers nozzle and block keep it from part and plate as well.

use crate::failure;
use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_kinematics::scene::{Body, Clearance as Distance, Scene, SceneModel, Shape, Sweep};
use curvlay_kinematics::workcell::{HOT_END, NOZZLE, PART, PLATE, Workcell};
use curvlay_toolpath::surface::{Contact, ContactError, Contacts, Moment, NozzlePart, Obstacle, Pose};
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::print::{self, Clearance, PrintCell, Waypoint};
use curvlay_trajectory::transfer::FreeSpace;
use nalgebra::{Isometry3, Point3, Translation3, UnitVector3};
use std::sync::Arc;

/// How fine sweeps look, in millimetres; and where that proves nothing.
const RESOLUTION_MM: f64 = 2.0;
const FINE_MM: f64 = 0.25;

/// The filter is told what is nearer than this, in millimetres.
const NEAR_MM: f64 = 30.0;

/// How much farther than the margin things stay apart at waypoints, in millimetres, by [`Clearance`]. The least is twice what fine
/// sweeps leave undecided.
pub const CLEARANCES_MM: [f64; Clearance::ALL.len()] = [9.5, 2.5, 2.0 * FINE_MM];

/// A workcell with the part in it as far as it is built.
#[derive(Clone)]
pub struct GrowingCell<'a, const N: usize, const F: usize, W> {
    /// The nozzle may touch part and plate: [`Contacts`] judges it.
    printing: Scene,
    /// The same for postures, which keep a distance that motions may use up: [`CLEARANCES_MM`].
    clear: [Scene; CLEARANCES_MM.len()],
    /// Nothing may touch anything. One layer behind while transfers lead to the layer that is printed next.
    moving: Scene,
    cell: &'a W,
    field: &'a FieldRun,
    contacts: &'a Contacts<'a>,
    outline: Outline,
    frame_part: Isometry3<f64>,
    /// Cells by the surface at which they are built, from 0.
    layers: Arc<[Vec<u32>]>,
    /// Surfaces that are there while one is printed, that one included, and behind transfers.
    begun: usize,
    built: usize,
}

/// What of the nozzle comes nearest to the plate: its tip flat, and the block from where to where it reaches above the tip.
#[derive(Clone, Copy)]
struct Outline {
    tip_radius: f64,
    block_radius: f64,
    block: [f64; 2],
}

/// What grows in a workcell.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    pub field: &'a FieldRun,
    pub surfaces: &'a SurfacesRun,
    pub contacts: &'a Contacts<'a>,
    /// Maps the part to the frame of what carries it.
    pub frame_part: Isometry3<f64>,
    /// How far things stay apart.
    pub margin_mm: f64,
}

impl<'a, const N: usize, const F: usize, W: Workcell<N, F>> GrowingCell<'a, N, F, W> {
    pub fn new(cell: &'a W, job: &Job<'a>) -> Result<Self, Failure> {
        let Job { field, surfaces, contacts, frame_part, margin_mm } = *job;
        let (grid, equipment) = (&field.solid.grid, cell.equipment());
        let (carrier, part_frame) = equipment.part_frame();
        let nozzle = equipment.model().nozzle;
        let outline = Outline {
            tip_radius: 0.5 * nozzle.tip_flat_mm,
            block_radius: 0.5 * nozzle.block_diameter_mm,
            block: [nozzle.cone_height_mm, nozzle.block_top_mm],
        };
        let nothing = vec![0; grid.rows().len()];
        let part = Body {
            name: PART.into(),
            mount: carrier,
            mount_body: part_frame * frame_part * Translation3::from(grid.origin().coords),
            shape: Shape::Cells { dims: grid.dims(), rows: nothing, cell: grid.cell_mm() },
        };
        let mut model = equipment.scene(field.platform_diameter_mm());
        model.bodies.push(part);
        let allowed = of_nozzle(&[PART, PLATE]);
        let model = SceneModel { margin: margin_mm, ..model };
        let with = |more: f64| {
            let model = SceneModel { margin: margin_mm + more, allowed: allowed.clone(), ..model.clone() };
            Scene::new(model).map_err(failure)
        };
        let [wide, aloof, close] = CLEARANCES_MM.map(with);
        let (clear, printing) = ([wide?, aloof?, close?], with(0.0)?);
        let moving = Scene::new(model).map_err(failure)?;
        let layers = layers(field, surfaces).into();
        let (begun, built) = (0, 0);
        Ok(GrowingCell { printing, clear, moving, cell, field, contacts, outline, frame_part, layers, begun, built })
    }

    /// Where the nozzle is on what carries the part.
    pub fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.cell.nozzle_on_part(joints)
    }

    /// Maps the part to the frame of what carries it.
    pub fn frame_part(&self) -> &Isometry3<f64> {
        &self.frame_part
    }

    /// Where a nozzle over what carries the part is in the part.
    fn in_part(&self, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Pose {
        let tip = self.frame_part.inverse_transform_point(tip);
        Pose { tip, direction: self.frame_part.inverse_transform_unit_vector(axis) }
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

    /// What may touch on a cubic piece of a motion while the nozzle prints or leaves its path, in words.
    pub fn touches_printing(&self, control: &[[f64; N]; 4]) -> Option<String> {
        self.touches_in(&self.printing, control)
    }

    /// The same on a transfer.
    pub fn touches_moving(&self, control: &[[f64; N]; 4]) -> Option<String> {
        self.touches_in(&self.moving, control)
    }

    /// What is not proven apart on a cubic piece of a motion, in words.
    fn touches_in(&self, scene: &Scene, control: &[[f64; N]; 4]) -> Option<String> {
        let control = control.map(|joints| self.cell.scene_posture(&joints));
        let looked = |resolution| match scene.sweep_cubic(&control, resolution) {
            Ok(Sweep::Free) => None,
            Ok(Sweep::Near { bodies: [a, b], .. }) => Some(format!("{a} and {b}")),
            Err(error) => Some(error.to_string()),
        };
        looked(RESOLUTION_MM).and_then(|_| looked(FINE_MM))
    }

    /// Where the nozzle is deepest in what is built at some moment, or in the plate, if that is deeper than it may be, standing
    /// over what carries the part.
    ///
    /// # Errors
    /// A question that has no answer is not "nowhere".
    pub fn deepest(
        &self,
        moment: Moment,
        tip: &Point3<f64>,
        axis: &UnitVector3<f64>,
    ) -> Result<Option<Contact>, ContactError> {
        let of_layers = self.contacts.deepest(moment, &self.in_part(tip, axis))?;
        let all = of_layers.into_iter().chain(self.below_plate(tip, axis));
        Ok(all.max_by(|a, b| a.depth.total_cmp(&b.depth)))
    }

    /// How deep the nozzle is in the plate. Its block has an upper end here, so that it may lie flat; the edge of the cone is
    /// within the block.
    fn below_plate(&self, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<Contact> {
        let lean = (1.0 - axis.z * axis.z).max(0.0).sqrt();
        let Outline { tip_radius, block_radius, block: [from, to] } = self.outline;
        let edges = [
            (NozzlePart::Tip, 0.0, tip_radius),
            (NozzlePart::Block, from, block_radius),
            (NozzlePart::Block, to, block_radius),
        ];
        let depths = edges.map(|(part, height, radius)| (part, radius * lean - tip.z - axis.z * height));
        let (part, depth) = depths.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let point = self.frame_part.inverse_transform_point(tip);
        (depth > 0.0).then_some(Contact { obstacle: Obstacle::Plate, depth, height: 0.0, part, point })
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> PrintCell<N> for GrowingCell<'_, N, F, W> {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        let (rows, until) = self.rows(self.begun, layer);
        for scene in self.clear.iter_mut().chain([&mut self.printing]) {
            scene.add_cells(PART, &rows).map_err(|error| error.to_string())?;
        }
        self.begun = until;
        Ok(())
    }

    fn build(&mut self, layer: u32) -> Result<(), String> {
        let (rows, until) = self.rows(self.built, layer);
        self.moving.add_cells(PART, &rows).map_err(|error| error.to_string())?;
        self.built = until;
        Ok(())
    }

    fn keeps(&self, joints: &[f64; N], clearance: Clearance) -> bool {
        matches!(self.clear[clearance as usize].touching(&self.cell.scene_posture(joints)), Ok(None))
    }

    fn obstacle(&self, joints: &[f64; N]) -> Option<String> {
        let [a, b] = self.clear[Clearance::Least as usize].touching(&self.cell.scene_posture(joints)).ok()??;
        Some(format!("{a} and {b}"))
    }

    fn touches(&self, control: &[[f64; N]; 4]) -> Option<String> {
        self.touches_printing(control)
    }

    fn is_gouging(&self, moment: print::Moment, nozzle: &Waypoint) -> bool {
        let moment = match moment {
            print::Moment::At { path, waypoint } => Moment::At { path, waypoint },
            print::Moment::After { path } => Moment::After { path },
        };
        let pose = self.in_part(&nozzle.position, &nozzle.axis);
        let above_plate = self.below_plate(&nozzle.position, &nozzle.axis).is_none();
        !(above_plate && self.contacts.is_free(moment, &pose).unwrap_or(false))
    }
}

/// Pairs of the nozzle, cone and block, with each of these.
pub fn of_nozzle(others: &[&str]) -> Vec<[String; 2]> {
    let pairs = |a: &str| others.iter().map(|b| [a.to_owned(), (*b).to_owned()]).collect::<Vec<_>>();
    [NOZZLE, HOT_END].into_iter().flat_map(pairs).collect()
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

impl<const N: usize, const F: usize, W: Workcell<N, F>> FreeSpace<N> for GrowingCell<'_, N, F, W> {
    fn free(&self, from: &[f64; N], to: &[f64; N]) -> bool {
        let [from, to] = [from, to].map(|joints| self.cell.scene_posture(joints));
        matches!(self.moving.is_free(&from, &to, RESOLUTION_MM), Ok(true))
    }

    fn posture_free(&self, joints: &[f64; N]) -> bool {
        matches!(self.moving.touching(&self.cell.scene_posture(joints)), Ok(None))
    }
}

/// How far a posture is from what the arm must not touch while it prints, in millimetres below zero; the margin is.
impl<const N: usize, const F: usize, W: Workcell<N, F>> CollisionIndicator<N> for GrowingCell<'_, N, F, W> {
    fn value(&self, joints: &[f64; N]) -> f64 {
        self.gradient(joints).0
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        match self.printing.clearance(&self.cell.scene_posture(joints), NEAR_MM) {
            Ok(Some(Distance { nearest, joints, table })) => {
                let slope = |j: usize| -if j < joints.len() { joints[j] } else { table[j - joints.len()] };
                (self.printing.margin() - nearest.distance, std::array::from_fn(slope))
            }
            Ok(None) | Err(_) => (self.printing.margin() - NEAR_MM, [0.0; N]),
        }
    }
}
