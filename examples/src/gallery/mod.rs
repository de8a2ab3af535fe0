//! The parts of the gallery (`docs/gallery.md`): twelve shapes made in code, each with the options of `curved_layers` that plan it.
//!
//! All are functions below zero inside, made a mesh by [`polygonise`]: closed and oriented by construction.

mod forms;
mod vessels;

use crate::mesh::Mesh;
use curvlay_voxel::{ImplicitMesh, polygonise};
use nalgebra::Point3;

/// A part of the gallery.
#[derive(Clone, Copy, Debug)]
pub struct GalleryPart {
    /// Name of the part and of its file.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Options of `curved_layers` after the name of the file.
    pub options: &'static str,
    /// What it is printed on: its file is the name with `-base`.
    pub base: Option<Solid>,
    solid: Solid,
}

/// A solid as a function, and what it needs to become a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    /// Below zero inside; about the distance from the surface, mm.
    distance: fn(Point3<f64>) -> f64,
    /// A box around it, from z = 0 on.
    low: [f64; 2],
    high: [f64; 3],
    /// Edge of the lattice on which it is cut out, mm.
    cell: f64,
}

/// How far rounding may lift a vertex off the plate, in mm; real features are larger by far.
const ROUNDING: f64 = 1e-6;

impl Solid {
    /// The surface of the solid above the plate z = 0: watertight, in mm.
    pub fn mesh(&self) -> Mesh {
        // Half a cell between lattice and plate keeps the foot smooth.
        let low = Point3::new(self.low[0], self.low[1], -2.5 * self.cell);
        let above_plate = |p: Point3<f64>| (self.distance)(p).max(-p.z);
        let surface = polygonise(above_plate, low, self.high.into(), self.cell);
        let ImplicitMesh { vertices, triangles } =
            surface.unwrap_or_else(|error| unreachable!("a solid of the gallery has a box: {error}"));
        let mut mesh = Mesh { vertices, triangles };
        mesh.vertices.iter_mut().filter(|vertex| vertex.z.abs() < ROUNDING).for_each(|vertex| vertex.z = 0.0);
        mesh
    }
}

impl GalleryPart {
    /// The mesh of the part.
    pub fn mesh(&self) -> Mesh {
        self.solid.mesh()
    }

    /// The command that plans the part; the files are those that `gallery --out target/gallery` has written.
    pub fn command(&self) -> String {
        let name = self.name;
        let on = self.base.map_or_else(String::new, |_| format!(" --on target/gallery/{name}-base.stl"));
        let options = self.options;
        format!(
            "cargo run --release --example curved_layers -- target/gallery/{name}.stl{on} {options} --out target/out/{name}"
        )
    }
}

const fn solid(distance: fn(Point3<f64>) -> f64, low: [f64; 2], high: [f64; 3], cell: f64) -> Solid {
    Solid { distance, low, high, cell }
}

const fn part(name: &'static str, about: &'static str, options: &'static str, solid: Solid) -> GalleryPart {
    GalleryPart { name, about, options, base: None, solid }
}

/// Layers and beads of a nozzle of 0.8 mm: a part takes seconds to a minute of two idle cores.
const FINE: &str = "--layer-height 0.6 --bead 0.9";
/// Of a coarser nozzle.
const COARSE: &str = "--layer-height 0.8 --bead 1.2";

/// The twelve parts, in the order of the page.
pub const PARTS: [GalleryPart; 12] = [
    part(
        "boat",
        "a small boat: hull, cabin with windows, chimney",
        FINE,
        solid(vessels::boat, [-22.0, -11.0], [22.0, 11.0, 32.0], 0.4),
    ),
    part("pipe", "a pipe that branches", FINE, solid(vessels::pipe, [-24.0, -10.0], [24.0, 10.0, 44.0], 0.7)),
    part(
        "vase",
        "a vase with a wall of two beads, bulged and twisted",
        FINE,
        solid(vessels::vase, [-21.0, -21.0], [21.0, 21.0, 50.0], 0.7),
    ),
    part(
        "dome",
        "half a hollow ball, open below",
        COARSE,
        solid(vessels::dome, [-22.0, -22.0], [22.0, 22.0, 23.0], 0.7),
    ),
    GalleryPart {
        name: "mould",
        about: "a dish laid over a mould",
        options: FINE,
        base: Some(solid(vessels::dish_mould, [-26.0, -21.0], [26.0, 21.0, 13.0], 0.7)),
        solid: solid(vessels::dish, [-24.0, -19.0], [24.0, 19.0, 17.0], 0.7),
    },
    part(
        "lattice",
        "a gyroid between two plates",
        FINE,
        solid(forms::lattice, [-13.0, -13.0], [13.0, 13.0, 26.0], 0.7),
    ),
    part(
        "bracket",
        "a bracket with a gusset and two holes",
        COARSE,
        solid(forms::bracket, [-2.0, -11.0], [34.0, 11.0, 34.0], 0.4),
    ),
    part("tee", "a T whose arms hang out by 15 mm", FINE, solid(forms::tee, [-22.0, -6.0], [22.0, 6.0, 36.0], 0.7)),
    part(
        "propeller",
        "a hub with three twisted blades",
        COARSE,
        solid(forms::propeller, [-26.0, -26.0], [26.0, 26.0, 16.0], 0.4),
    ),
    part("arch", "a bridge between two feet", FINE, solid(forms::arch, [-25.0, -7.0], [25.0, 7.0, 26.0], 0.7)),
    part("hook", "a hook that ends in the air", COARSE, solid(forms::hook, [-12.0, -8.0], [36.0, 8.0, 40.0], 0.7)),
    part("tree", "a trunk with five limbs", COARSE, solid(forms::tree, [-26.0, -26.0], [26.0, 26.0, 48.0], 0.7)),
];
