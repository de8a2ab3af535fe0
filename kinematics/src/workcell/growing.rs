//! The scene of a print: a workcell with the layers that are built so far.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), sections 2.5 and 3.5.3. The part is made of cells and grows
//! layer by layer. What must keep apart depends on what the robot does, so there are three states of one scene:
//! * *printing*: nozzle and hot end may touch the part and the plate, everything else keeps the margin;
//! * *printing with a clearance*: the same for single postures, which keep a distance that motions between them may use up;
//! * *moving*: everything keeps the margin.
//!
//! How deep the nozzle may be in the part while it prints is not a question for this scene, whose cells are as coarse as layers;
//! [`Equipment::depth_in_plate`](super::Equipment::depth_in_plate) answers for the plate.

use super::Workcell;
use super::equipment::{HOT_END, NOZZLE, PART, PLATE};
use crate::scene::{
    Body, Clearance, MIN_RESOLUTION, PostureError, Scene, SceneError, SceneModel, Shape, Sweep, SweepError,
};
use nalgebra::{Isometry3, Point3, Translation3};
use std::sync::Arc;

/// How much more than the margin postures keep apart while printing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ClearanceLevel {
    /// Enough for smooth motions and for lifting off.
    Wide,
    /// Less, for paths that cannot be followed so.
    Narrow,
    /// As little as proofs of motions need.
    Least,
}

impl ClearanceLevel {
    /// All of them, the widest first.
    pub const ALL: [ClearanceLevel; 3] = [ClearanceLevel::Wide, ClearanceLevel::Narrow, ClearanceLevel::Least];
}

/// How a [`GrowingScene`] is asked. All in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowingOptions {
    /// What is this near counts as touching. Default [2](GrowingOptions::MARGIN_MM): twice the error of the bodies of links
    /// ([`LinkSource::error_mm`](crate::scene::LinkSource::error_mm)).
    pub margin_mm: f64,
    /// How much farther than the margin things are apart at postures, by [`ClearanceLevel`]; links with one link between them less
    /// ([`SceneModel::clearance`]). Not rising. Default 9.5, 2.5 and 0.5. The
    /// least should be twice the fine resolution, or sweeps through such postures may not be proven free.
    pub clearances_mm: [f64; 3],
    /// Resolution of sweeps. Default 2: coarse sweeps cost an eighth of fine ones.
    pub resolution_mm: f64,
    /// Resolution where the first proves nothing. Default 0.25: with more, narrow passes count as closed.
    pub fine_resolution_mm: f64,
    /// The indicator does not look farther than this. Default 30: with less, filters of motions react too late.
    pub near_mm: f64,
    /// Whether the arm has no bodies: then nothing says what it touches, and nothing may be called free. Default false: an arm
    /// without bodies is refused.
    pub without_links: bool,
}

impl Default for GrowingOptions {
    fn default() -> Self {
        GrowingOptions {
            margin_mm: GrowingOptions::MARGIN_MM,
            clearances_mm: GrowingOptions::CLEARANCES_MM,
            resolution_mm: 2.0,
            fine_resolution_mm: 0.25,
            near_mm: 30.0,
            without_links: false,
        }
    }
}

/// A part as cells, and the layers in which it is built.
#[derive(Clone, Copy, Debug)]
pub struct PartCells<'a> {
    /// Cells along x, y and z.
    pub dims: [u32; 3],
    /// All cells of the part: bit `x % 64` of word `x / 64` of row `y + ny z`, each row in whole words.
    pub rows: &'a [u64],
    /// Edge of a cell, in millimetres.
    pub cell_mm: f64,
    /// Low corner of the grid in the part, in millimetres.
    pub origin: Point3<f64>,
    /// Maps the part to the part frame of the workcell.
    pub frame_part: Isometry3<f64>,
    /// The cells of each layer, numbered `x + nx (y + ny z)`, in the order in which layers are built.
    pub layers: &'a [Vec<u32>],
}

/// Why there is no scene of a print.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowingError {
    /// An option cannot be what it is.
    #[error("`{option}` is {value}: it must be {must}")]
    Option {
        /// The field of [`GrowingOptions`].
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A layer names a cell that the part does not have.
    #[error("layer {layer} has cell {cell}, which is no cell of the part")]
    Cell {
        /// The layer, from 0.
        layer: usize,
        /// The cell.
        cell: u32,
    },
    /// The arm has no bodies, so nothing can be said of what it touches.
    #[error(
        "the arm of the workcell has no bodies, so no motion can be proven free: name those of a known arm or give link meshes \
         (`arm.bodies`), or plan without links"
    )]
    NoLinks,
    /// The bodies make no scene: the grid, the pose of the part, the margin or the plate.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// A workcell with the layers that are built so far. See the documentation of [`GrowingOptions`] for the distances.
///
/// Layers are numbered from 0; [`begin`](Self::begin) and [`build`](Self::build) add them. All queries take `&self`, and a
/// clone costs as much memory as four scenes with their cells.
///
/// # Example
/// ```
/// use curvlay_kinematics::Waypoint;
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
/// use curvlay_kinematics::workcell::{AnyWorkcell, ClearanceLevel, GrowingOptions, GrowingScene, PartCells, Workcell};
/// # #[cfg(feature = "serde")] {
/// let file = include_str!("../../../examples/cells/ur3.json");
/// let AnyWorkcell::Six(workcell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has a table".into()) };
/// // A block of 20 x 20 x 4 mm in two layers, in the middle of a plate of 120 mm.
/// let layers = [(0..100).collect::<Vec<u32>>(), (100..200).collect()];
/// let part = PartCells {
///     dims: [10, 10, 2], rows: &[0x3ff; 20], cell_mm: 2.0, origin: Point3::new(-10.0, -10.0, 0.0),
///     frame_part: Isometry3::identity(), layers: &layers,
/// };
/// let mut scene = GrowingScene::new(&workcell, &part, 120.0, &GrowingOptions::default())?;
/// // A posture with the nozzle upright on the first layer.
/// let waypoint = Waypoint { position: Point3::new(0.0, 0.0, 2.0), axis: Vector3::z_axis() };
/// let mut found = None;
/// for sample in 0..24 {
///     workcell.solutions(&waypoint, &[0.25 * f64::from(sample)], &mut |_, joints| {
///         let fits = matches!(scene.touching_printing(&joints, ClearanceLevel::Least), Ok(None));
///         found = found.or(fits.then_some(joints));
///     });
/// }
/// let joints = found.ok_or("nowhere")?;
/// // It may touch the part while it prints, and not while it moves.
/// scene.begin(0)?;
/// scene.build(0)?;
/// assert_eq!(scene.touching_printing(&joints, ClearanceLevel::Least)?, None);
/// // The plate, 2 mm beneath the tip, is as near as the margin, and the part touches.
/// assert_eq!(scene.touching_moving(&joints)?, Some(["nozzle", "plate"]));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GrowingScene<'a, const N: usize, const F: usize, W> {
    workcell: &'a W,
    /// Nozzle and hot end may touch part and plate.
    printing: Scene,
    /// The same with the clearances.
    clear: [Scene; ClearanceLevel::ALL.len()],
    /// Nothing may touch anything. One layer behind while transfers lead to the layer that is printed next.
    moving: Scene,
    options: GrowingOptions,
    dims: [u32; 3],
    words: usize,
    frame_part: Isometry3<f64>,
    layers: Arc<[Vec<u32>]>,
    /// Layers that are there while printing, and while moving.
    begun: usize,
    built: usize,
}

/// Pairs of the nozzle, cone and hot end, with each of these bodies, as [`SceneModel::allowed`] takes them.
///
/// ```
/// use curvlay_kinematics::workcell::{PLATE, nozzle_pairs};
/// assert_eq!(nozzle_pairs(&[PLATE]), [["nozzle", "plate"], ["hot end", "plate"]]);
/// ```
pub fn nozzle_pairs(others: &[&str]) -> Vec<[String; 2]> {
    let pairs = |a: &str| others.iter().map(|b| [a.to_owned(), (*b).to_owned()]).collect::<Vec<_>>();
    [NOZZLE, HOT_END].into_iter().flat_map(pairs).collect()
}

impl GrowingOptions {
    /// The margin that is the default: 2 mm.
    pub const MARGIN_MM: f64 = 2.0;

    /// The clearances that are the default, by [`ClearanceLevel`].
    pub const CLEARANCES_MM: [f64; 3] = [9.5, 2.5, 0.5];

    fn check(&self) -> Result<(), GrowingError> {
        let [wide, narrow, least] = self.clearances_mm;
        let falls = [wide, narrow, least, 0.0].is_sorted_by(|a, b| a >= b);
        let fine = |value: f64| value >= MIN_RESOLUTION && value.is_finite();
        let resolution = "finite and at least 1e-3 mm";
        let sound = [
            ("clearances_mm", wide, falls && wide.is_finite(), "finite, 0 or more, and not rising"),
            ("resolution_mm", self.resolution_mm, fine(self.resolution_mm), resolution),
            ("fine_resolution_mm", self.fine_resolution_mm, fine(self.fine_resolution_mm), resolution),
            ("near_mm", self.near_mm, self.near_mm >= 0.0 && self.near_mm.is_finite(), "finite and 0 or more"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, must)) => Err(GrowingError::Option { option, value, must }),
            None => Ok(()),
        }
    }
}

/// Word and bit of a cell; `None` beyond the grid.
fn place([nx, ny, nz]: [u32; 3], cell: u32) -> Option<(usize, u64)> {
    let [nx, ny, nz, cell] = [nx, ny, nz, cell].map(u64::from);
    let (x, row) = (cell % nx.max(1), cell / nx.max(1));
    (row < ny * nz).then_some(((row * nx.div_ceil(64) + x / 64) as usize, 1 << (x % 64)))
}

impl<'a, const N: usize, const F: usize, W: Workcell<N, F>> GrowingScene<'a, N, F, W> {
    /// The workcell before anything is built.
    ///
    /// # Arguments
    /// * `plate_mm`: diameter of the plate, where the workcell leaves it open.
    ///
    /// # Errors
    /// [`GrowingError`] names the option, the layer and its cell, or the body.
    ///
    /// # Cost
    /// `O(words + cells)` time; five scenes of memory.
    pub fn new(
        workcell: &'a W,
        part: &PartCells<'_>,
        plate_mm: f64,
        options: &GrowingOptions,
    ) -> Result<Self, GrowingError> {
        options.check()?;
        let PartCells { dims, rows, cell_mm, origin, frame_part, layers } = *part;
        let equipment = workcell.equipment();
        let (carrier, part_frame) = equipment.part_frame();
        let body = Body {
            name: PART.into(),
            mount: carrier,
            mount_body: part_frame * frame_part * Translation3::from(origin.coords),
            shape: Shape::Cells { dims, rows: vec![0; rows.len()], cell: cell_mm },
        };
        let mut model = equipment.scene(plate_mm);
        if options.without_links {
            model.links.clear();
        } else if equipment.link_bodies().is_none() {
            return Err(GrowingError::NoLinks);
        }
        model.bodies.push(body);
        let mut allowed = nozzle_pairs(&[PART, PLATE]);
        if equipment.roller().is_some() {
            // The block of a tape head stands above the roller: it keeps off what is built.
            allowed.retain(|pair| pair[0] != HOT_END);
        }
        let model = SceneModel { margin: options.margin_mm, ..model };
        let with = |clearance: f64| Scene::new(SceneModel { clearance, allowed: allowed.clone(), ..model.clone() });
        // Of these the first looks at the grid.
        let printing = with(0.0)?;
        let [wide, narrow, least] = options.clearances_mm.map(with);
        let clear = [wide?, narrow?, least?];
        let moving = Scene::new(model)?;
        let is_there = |cell: u32| place(dims, cell).is_some_and(|(word, bit)| rows[word] & bit != 0);
        for (layer, cells) in layers.iter().enumerate() {
            if let Some(&cell) = cells.iter().find(|&&cell| !is_there(cell)) {
                return Err(GrowingError::Cell { layer, cell });
            }
        }
        Ok(GrowingScene {
            workcell,
            printing,
            clear,
            moving,
            options: *options,
            dims,
            words: rows.len(),
            frame_part,
            layers: layers.into(),
            begun: 0,
            built: 0,
        })
    }

    /// The same with a mould, or a part that exists already, which is there from the start: by its cells, as [`PartCells::rows`] has those of the part. Nozzle and
    /// hot end may touch it while they print, as they may the part.
    ///
    /// # Errors
    /// [`SceneError`] for rows of another grid.
    ///
    /// # Cost
    /// `O(words)`.
    pub fn on_mould(mut self, rows: &[u64]) -> Result<Self, SceneError> {
        for scene in self.clear.iter_mut().chain([&mut self.printing, &mut self.moving]) {
            scene.add_cells(PART, rows)?;
        }
        Ok(self)
    }

    /// The workcell.
    pub fn workcell(&self) -> &'a W {
        self.workcell
    }

    /// Maps the part to the part frame of the workcell.
    pub fn frame_part(&self) -> &Isometry3<f64> {
        &self.frame_part
    }

    /// The distances.
    pub fn options(&self) -> &GrowingOptions {
        &self.options
    }

    /// Layers that are there while printing, and while moving.
    pub fn layers(&self) -> [usize; 2] {
        [self.begun, self.built]
    }

    /// Rows of the cells of the layers from one up to another, and how many layers there are then.
    fn rows(&self, from: usize, layer: u32) -> (Vec<u64>, usize) {
        let until = (layer as usize).saturating_add(1).min(self.layers.len()).max(from);
        let mut rows = vec![0; self.words];
        for &cell in self.layers[from..until].iter().flatten() {
            if let Some((word, bit)) = place(self.dims, cell) {
                rows[word] |= bit;
            }
        }
        (rows, until)
    }

    /// While printing, the part is there up to a layer, that one included, from now on. A layer beyond the last is the last;
    /// one that is there already changes nothing.
    ///
    /// # Errors
    /// [`SceneError`]; none with a scene that was made by [`GrowingScene::new`].
    ///
    /// # Cost
    /// `O(words + new cells)`.
    pub fn begin(&mut self, layer: u32) -> Result<(), SceneError> {
        let (rows, until) = self.rows(self.begun, layer);
        for scene in self.clear.iter_mut().chain([&mut self.printing]) {
            scene.add_cells(PART, &rows)?;
        }
        self.begun = until;
        Ok(())
    }

    /// The same while moving.
    ///
    /// # Errors
    /// As [`GrowingScene::begin`].
    pub fn build(&mut self, layer: u32) -> Result<(), SceneError> {
        let (rows, until) = self.rows(self.built, layer);
        self.moving.add_cells(PART, &rows)?;
        self.built = until;
        Ok(())
    }

    /// Two bodies that are not farther apart than margin and clearance at a posture while printing.
    ///
    /// # Errors
    /// [`PostureError`] names the joint that is no angle.
    ///
    /// # Cost
    /// As [`Scene::touching`], like all queries at a posture.
    pub fn touching_printing(
        &self,
        joints: &[f64; N],
        clearance: ClearanceLevel,
    ) -> Result<Option<[&str; 2]>, PostureError> {
        self.clear[clearance as usize].touching(&self.workcell.scene_posture(joints))
    }

    /// Two bodies that are not farther apart than the margin at a posture while moving.
    ///
    /// # Errors
    /// [`PostureError`] names the joint that is no angle.
    pub fn touching_moving(&self, joints: &[f64; N]) -> Result<Option<[&str; 2]>, PostureError> {
        self.moving.touching(&self.workcell.scene_posture(joints))
    }

    /// Two bodies that are not proven to keep the margin on a cubic piece of a motion while printing; `None` only with a proof.
    ///
    /// # Arguments
    /// * `control`: Bezier control points of the piece in joint space, as [`Scene::sweep_cubic`] takes them.
    ///
    /// # Errors
    /// [`SweepError`] names the control point and the joint.
    ///
    /// # Cost
    /// That of a sweep with the coarse resolution, and of one with the fine resolution where that proves nothing.
    pub fn sweep_printing(&self, control: &[[f64; N]; 4]) -> Result<Option<[&str; 2]>, SweepError> {
        self.sweep(&self.printing, control)
    }

    /// The same while moving.
    ///
    /// # Errors
    /// As [`GrowingScene::sweep_printing`].
    pub fn sweep_moving(&self, control: &[[f64; N]; 4]) -> Result<Option<[&str; 2]>, SweepError> {
        self.sweep(&self.moving, control)
    }

    fn sweep<'s>(&self, scene: &'s Scene, control: &[[f64; N]; 4]) -> Result<Option<[&'s str; 2]>, SweepError> {
        let control = control.map(|joints| self.workcell.scene_posture(&joints));
        let looked = |resolution| match scene.sweep_cubic(&control, resolution)? {
            Sweep::Free => Ok(None),
            Sweep::Near { bodies, .. } => Ok(Some(bodies)),
        };
        match looked(self.options.resolution_mm)? {
            None => Ok(None),
            Some(_) => looked(self.options.fine_resolution_mm),
        }
    }

    /// Whether the straight motion in joint space is free while moving, at the coarse resolution.
    ///
    /// # Errors
    /// [`SweepError`] names the joint.
    pub fn is_moving_free(&self, from: &[f64; N], to: &[f64; N]) -> Result<bool, SweepError> {
        let [from, to] = [from, to].map(|joints| self.workcell.scene_posture(joints));
        self.moving.is_free(&from, &to, self.options.resolution_mm)
    }

    /// A collision indicator: how far a posture is from what must not touch while printing, in millimetres below zero, with
    /// the margin at zero, and its derivative by the joints, in millimetres a radian. Where nothing is within `near_mm` of each
    /// other, `margin_mm - near_mm` and zero; the same for an invalid posture.
    ///
    /// # Cost
    /// As [`Scene::clearance`].
    pub fn indicator(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        let GrowingOptions { margin_mm, near_mm, .. } = self.options;
        match self.printing.clearance(&self.workcell.scene_posture(joints), near_mm) {
            Ok(Some(Clearance { nearest, joints, table })) => {
                let slope = |j: usize| -if j < joints.len() { joints[j] } else { table[j - joints.len()] };
                (margin_mm - nearest.distance, std::array::from_fn(slope))
            }
            Ok(None) | Err(_) => (margin_mm - near_mm, [0.0; N]),
        }
    }
}
