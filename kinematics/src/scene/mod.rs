//! The collision scene: an arm, its tool, a table and the part as built so far; what touches, how far apart things
//! are, and whether a motion is free.
//!
//! ```
//! use curvlay_kinematics::nalgebra::{Isometry3, Point3};
//! use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, Sweep, links};
//! use curvlay_kinematics::{Arm, robots};
//!
//! let body = |name: &str, mount, shape| Body { name: name.into(), mount, mount_body: Isometry3::identity(), shape };
//! let nozzle = Shape::Capsule { from: Point3::new(0.0, 0.0, 5.0), to: Point3::new(0.0, 0.0, 95.0), radius: 5.0 };
//! let desk = Shape::block(Point3::new(-600.0, -600.0, -40.0), Point3::new(600.0, 600.0, 0.0));
//! let cube = Shape::Cells { dims: [20, 20, 10], rows: vec![0xf_ffff; 200], cell: 2.0 };
//! let mut part = body("part", Mount::Base, cube);
//! part.mount_body = Isometry3::translation(-320.0, -130.0, 0.0);
//! let scene = Scene::new(SceneModel {
//!     bodies: vec![body("nozzle", Mount::Link(6), nozzle), body("desk", Mount::Base, desk), part],
//!     // The foot stands on the desk, and so does the part: what never moves against each other is not compared.
//!     links: links(&robots::UR3),
//!     ..SceneModel::of(Arm::new(&robots::UR3)?)
//! })?;
//! let above = [0.0, -1.3, -1.5, -1.9, 1.5708, 0.0].into();
//! assert_eq!(scene.touching(&above)?, None);
//! let nearest = scene.nearest(&above)?.ok_or("nothing there")?;
//! assert!(nearest.distance > 0.0);
//! // Down into the desk: the sweep says where it ends.
//! let below = [0.0, 0.6, -1.5, -1.9, 1.5708, 0.0].into();
//! assert!(matches!(scene.sweep(&above, &below, 0.1)?, Sweep::Near { .. }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **What is compared.** Two bodies of different mounts, but for these pairs, which [`Scene::pairs`] no longer lists:
//! * links of the arm next to each other, which meet at their joint ([`SceneModel::links`]; a tool is no link);
//! * pairs that the caller allows to touch ([`SceneModel::allowed`]);
//! * pairs *proven* to stay farther apart than the margin at all joints: with one joint between them, one body lies in a
//!   capsule about that joint's axis, with more of them in a ball whose radius is a sum of lengths of links, and the other
//!   body is apart from that. Sampling joints proves nothing and is not done.
//!
//! **What the answers are worth.** "Apart" is said only with a proof: a plane with all of one convex piece on one
//! side and all of the other beyond it, checked on the points, or boxes that a separating axis parts. So bodies may be
//! said to touch that are up to a millionth of a millimetre (or of their distance) farther apart than the margin, never the
//! reverse. [`Scene::sweep`] is a proof for the motion as a whole, not for samples of it.
//!
//! **Which motion.** [`Scene::sweep`] proves the straight motion in joint space, [`Scene::sweep_cubic`] a cubic one: a piece
//! of the spline that a robot executes, which between its knots leaves the straight line by millimetres. Prove what runs.
//!
//! Nothing here depends on threads or on what was asked before; all queries take `&self`.

mod body;
mod bounds;
mod cells;
mod chain;
mod hulls;
mod links;
mod mesh;
mod motion;
mod narrow;
mod pairs;
mod piece;
mod query;
mod rounding;
mod search;
mod sweep;

pub use crate::pose::MAX_COORDINATE;
pub use body::{Body, Mount, SceneError, Shape};
pub(crate) use hulls::convex_pieces;
pub(crate) use links::link_body;
pub use links::{LINK_NAMES, LinkSource, estimated_links, link_source, links};
pub use motion::cubic_control;
pub use query::{Clearance, Nearest, Posture, PostureError};
pub(crate) use sweep::MIN_RESOLUTION;
pub use sweep::{Sweep, SweepError};

use crate::arm::Arm;
use crate::positioner::Positioner;
use crate::track::Track;
use chain::Chain;
use nalgebra::{Isometry3, Point3};
use piece::{Form, Piece};

/// What a scene is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneModel {
    /// The arm, which stands in the origin.
    pub arm: Arm,
    /// The positioner, where there is one.
    pub positioner: Option<Positioner>,
    /// The track along which the base of the arm travels, where there is one; then there is no positioner.
    pub track: Option<Track>,
    /// The links of the arm: see [`links`]. Of these, neighbours are not compared: bodies on frames `k` and `k + 1`.
    pub links: Vec<Body>,
    /// Everything else: tool, table, part, walls. These are compared with all that moves against them.
    pub bodies: Vec<Body>,
    /// Pairs of names that may touch: the nozzle and the layer under it, or a foot and the floor it stands on.
    pub allowed: Vec<[String; 2]>,
    /// What is this near, in millimetres, counts as touching.
    pub margin: f64,
    /// By how much the links are thicker than their bodies, in millimetres, against everything that is no link: for cables,
    /// hoses and clips that run along them. Against each other links are as thick as their bodies. Default 0.
    pub link_allowance: f64,
    /// What bodies keep apart beyond the margin, in millimetres, for postures that motions may leave by so much; links with one
    /// link between them, which rest side by side on many arms, keep at most 2 mm of it. Default 0.
    pub clearance: f64,
}

impl SceneModel {
    /// Nothing but an arm without bodies; margin, allowance and clearance are 0.
    pub fn of(arm: Arm) -> Self {
        SceneModel {
            arm,
            positioner: None,
            track: None,
            links: vec![],
            bodies: vec![],
            allowed: vec![],
            margin: 0.0,
            link_allowance: 0.0,
            clearance: 0.0,
        }
    }
}

/// A body with its pieces.
#[derive(Clone, Debug)]
struct Placed {
    body: Body,
    is_link: bool,
    pieces: Vec<Piece>,
    /// How far its points can ever be from the axes that move it, from the base on.
    lever_arms: Vec<f64>,
}

/// A scene, ready to be asked. See the [module](self).
#[derive(Clone, Debug)]
pub struct Scene {
    arm: Arm,
    positioner: Option<Positioner>,
    track: Option<Track>,
    arm_chain: Chain,
    table_chain: Option<Chain>,
    /// Links first.
    bodies: Vec<Placed>,
    allowed: Vec<[usize; 2]>,
    margin: f64,
    link_allowance: f64,
    clearance: f64,
    /// Pairs that may touch, by index, in order.
    pairs: Vec<[usize; 2]>,
}

impl Scene {
    /// Checks and prepares a scene.
    ///
    /// # Errors
    /// [`SceneError`] names the body, and of it the point, triangle or row.
    ///
    /// # Cost
    /// `O(n log n)` for `n` triangles, `O(n)` for cells.
    pub fn new(model: SceneModel) -> Result<Self, SceneError> {
        let SceneModel { arm, positioner, track, links, bodies, allowed, margin, link_allowance, clearance } = model;
        if !(0.0..=MAX_COORDINATE).contains(&margin) {
            return Err(SceneError::Margin { value: margin });
        }
        if !(0.0..=MAX_COORDINATE).contains(&link_allowance) {
            return Err(SceneError::Allowance { value: link_allowance });
        }
        if !(0.0..=MAX_COORDINATE).contains(&clearance) {
            return Err(SceneError::Clearance { value: clearance });
        }
        if positioner.is_some() && track.is_some() {
            return Err(SceneError::TableAndTrack);
        }
        let mut scene = Scene {
            arm,
            positioner,
            track,
            arm_chain: Chain::of_arm(&arm),
            table_chain: positioner.as_ref().map(Chain::of_table),
            bodies: Vec::with_capacity(links.len() + bodies.len()),
            allowed: vec![],
            margin,
            link_allowance,
            clearance,
            pairs: vec![],
        };
        let all = links.into_iter().map(|body| (body, true)).chain(bodies.into_iter().map(|body| (body, false)));
        for (body, is_link) in all {
            if scene.index(&body.name).is_ok() {
                return Err(SceneError::SameName { name: body.name });
            }
            match body.mount {
                Mount::Link(link) if !(1..=6).contains(&link) => {
                    return Err(SceneError::Link { body: body.name, link });
                }
                Mount::Tilt | Mount::Table if scene.positioner.is_none() => {
                    return Err(SceneError::NoPositioner { body: body.name });
                }
                Mount::Ground | Mount::Rail if scene.track.is_none() => {
                    return Err(SceneError::NoTrack { body: body.name });
                }
                _ => {}
            }
            let pieces = body::pieces(&body)?;
            // The pieces hold the shape now.
            let body = Body { shape: Shape::Hull { points: vec![], radius: 0.0 }, ..body };
            let mut placed = Placed { body, is_link, pieces, lever_arms: vec![] };
            placed.lever_arms = scene.lever_arms(&placed);
            scene.bodies.push(placed);
        }
        for [a, b] in &allowed {
            let pair = [scene.index(a)?, scene.index(b)?];
            scene.allowed.push([pair[0].min(pair[1]), pair[0].max(pair[1])]);
        }
        scene.find_pairs();
        Ok(scene)
    }

    /// Whether postures have axes beside the joints of the arm.
    fn has_table(&self) -> bool {
        self.positioner.is_some() || self.track.is_some()
    }

    /// The margin, in millimetres.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// By how much the links are thicker than their bodies against what is no link, in millimetres.
    pub fn link_allowance(&self) -> f64 {
        self.link_allowance
    }

    /// By how much the two bodies of a pair are thicker than their shapes, against each other.
    fn growth(&self, [a, b]: &[usize; 2]) -> [f64; 2] {
        match (self.bodies[*a].is_link, self.bodies[*b].is_link) {
            (true, false) => [self.link_allowance, 0.0],
            (false, true) => [0.0, self.link_allowance],
            (true, true) | (false, false) => [0.0; 2],
        }
    }

    /// The names of the bodies, links first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.bodies.iter().map(|placed| placed.body.name.as_str())
    }

    /// The pairs that are compared, by name.
    pub fn pairs(&self) -> impl Iterator<Item = [&str; 2]> {
        self.pairs.iter().map(|pair| self.names_of(pair))
    }

    fn names_of(&self, pair: &[usize; 2]) -> [&str; 2] {
        pair.map(|k| self.bodies[k].body.name.as_str())
    }

    fn index(&self, name: &str) -> Result<usize, SceneError> {
        let found = self.bodies.iter().position(|placed| placed.body.name == name);
        found.ok_or_else(|| SceneError::NoBody { name: name.into() })
    }

    /// Gives a body another shape; everything else stays as it is.
    ///
    /// # Errors
    /// [`SceneError`] as for a new scene; then nothing has changed.
    pub fn replace(&mut self, name: &str, shape: Shape) -> Result<(), SceneError> {
        let at = self.index(name)?;
        let body = Body { shape, ..self.bodies[at].body.clone() };
        let pieces = body::pieces(&body)?;
        self.changed(at, |all| *all = pieces);
        Ok(())
    }

    /// Adds triangles to a body of triangles: one more layer of the part. `triangles` number the corners of `points`
    /// alone.
    ///
    /// # Errors
    /// [`SceneError`]; then nothing has changed.
    ///
    /// # Cost
    /// Trees of like size are merged, so `n` triangles in layers of any size cost `O(n log^2 n)` together, and a body
    /// is never more than about `log n` trees.
    pub fn add_triangles(
        &mut self,
        name: &str,
        points: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) -> Result<(), SceneError> {
        let at = self.index(name)?;
        if !self.bodies[at].pieces.iter().all(|piece| matches!(piece.form, Form::Mesh(_))) {
            return Err(SceneError::OtherShape { body: name.into(), what: "triangles" });
        }
        let piece = body::mesh(&self.bodies[at].body, points, triangles)?;
        self.changed(at, |all| {
            all.push(piece);
            merge(all);
        });
        Ok(())
    }

    /// Adds cells to a body of cells, in rows of the same grid; cells that are there already do no harm.
    ///
    /// # Errors
    /// [`SceneError`]; then nothing has changed.
    ///
    /// # Cost
    /// `O(words + new cells)`.
    pub fn add_cells(&mut self, name: &str, rows: &[u64]) -> Result<(), SceneError> {
        let at = self.index(name)?;
        let Some(Form::Cells(cells)) = self.bodies[at].pieces.first_mut().map(|piece| &mut piece.form) else {
            return Err(SceneError::OtherShape { body: name.into(), what: "cells" });
        };
        body::check_rows(name, cells.dims(), rows)?;
        cells.add(rows);
        // Bounds of motion are those of the grid and stay; but what nothing reached may be reached now.
        self.find_pairs();
        Ok(())
    }

    fn changed(&mut self, at: usize, change: impl FnOnce(&mut Vec<Piece>)) {
        change(&mut self.bodies[at].pieces);
        self.bodies[at].lever_arms = self.lever_arms(&self.bodies[at]);
        self.find_pairs();
    }
}

/// Joins the last trees of triangles until each is more than twice as large as the next.
fn merge(pieces: &mut Vec<Piece>) {
    let size = |piece: &Piece| if let Form::Mesh(mesh) = &piece.form { mesh.triangles().len() } else { 0 };
    while let [.., before, last] = pieces.as_slice() {
        if size(before) > 2 * size(last) {
            break;
        }
        let mut triangles = Vec::with_capacity(size(before) + size(last));
        for piece in [before, last] {
            if let Form::Mesh(mesh) = &piece.form {
                triangles.extend_from_slice(mesh.triangles());
            }
        }
        let pose: Isometry3<f64> = last.mount_piece;
        pieces.truncate(pieces.len() - 2);
        pieces.push(Piece::new(Form::Mesh(mesh::MeshTree::new(triangles)), 0.0, pose));
    }
}
