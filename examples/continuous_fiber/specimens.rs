//! The specimens of the dissertation (sections 5.4.1 and 5.4.2): a dumbbell, a bar, and an arc on a mould.

use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Point3, Vector3};

/// A specimen: layers of thermoplastic with a tape in the middle of each but the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// For file names and keys.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    shape: Shape,
    /// Layers of thermoplastic.
    pub layers: u32,
    /// Height of each, in millimetres.
    pub layer_mm: f64,
    /// Length and width of its tapes, in millimetres.
    pub tape_mm: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// Length and width.
    Bar { length: f64, width: f64 },
    /// ASTM D638, type I: overall length and width, the narrow part's, and the radius of the fillets.
    Dumbbell,
    /// On a cylinder.
    Arc { radius: f64, half_angle: f64, width: f64 },
}

/// ASTM D638, type I, in millimetres. The dissertation gives the shape only as "dumbbell"; its tapes of 150 mm fit this one.
const DUMBBELL: [f64; 5] = [165.0, 19.0, 57.0, 13.0, 76.0];
/// Its thickness: the dissertation does not give it.
pub const DUMBBELL_MM: f64 = 3.2;
/// Height of the mould's crown over the plate, in millimetres. The ends of the arc lie 12 mm lower.
pub const CROWN_MM: f64 = 25.0;
/// Half the angle of the mould: 80 degrees (section 5.3.2).
const MOULD_HALF_DEG: f64 = 40.0;
/// Distance of the points of a surface, in millimetres.
const STEP_MM: f64 = 2.0;
/// Rows of quads across a surface.
const ROWS: u32 = 6;

impl Specimen {
    /// All three.
    pub fn all() -> [Specimen; 3] {
        let bar = Shape::Bar { length: 250.0, width: 10.0 };
        let arc = Shape::Arc { radius: 60.0, half_angle: 37.5_f64.to_radians(), width: 10.0 };
        [
            Specimen {
                name: "dumbbell",
                title: "Dumbbell (tension)",
                shape: Shape::Dumbbell,
                layers: 6,
                layer_mm: DUMBBELL_MM / 6.0,
                tape_mm: [150.0, 5.0],
            },
            Specimen {
                name: "bar",
                title: "Bar (three-point bending)",
                shape: bar,
                layers: 10,
                layer_mm: 0.5,
                tape_mm: [240.0, 5.0],
            },
            Specimen {
                name: "arc",
                title: "Arc (curved layers)",
                shape: arc,
                layers: 7,
                layer_mm: 0.6,
                tape_mm: [68.0, 5.0],
            },
        ]
    }

    /// Whether its layers are curved.
    pub fn is_curved(&self) -> bool {
        matches!(self.shape, Shape::Arc { .. })
    }

    /// Width where it is tested, and height, in millimetres.
    pub fn section_mm(&self) -> [f64; 2] {
        let width = match self.shape {
            Shape::Bar { width, .. } | Shape::Arc { width, .. } => width,
            Shape::Dumbbell => DUMBBELL[3],
        };
        [width, f64::from(self.layers) * self.layer_mm]
    }

    /// Radius of the middle of an arc, in millimetres, and half its angle.
    pub fn arc(&self) -> Option<(f64, f64)> {
        match self.shape {
            Shape::Arc { radius, half_angle, .. } => Some((radius + self.section_mm()[1] / 2.0, half_angle)),
            _ => None,
        }
    }

    /// Half its length at a height, along the layer, in millimetres.
    fn half_length(&self, height: f64) -> f64 {
        match self.shape {
            Shape::Bar { length, .. } => length / 2.0,
            Shape::Dumbbell => DUMBBELL[0] / 2.0,
            Shape::Arc { radius, half_angle, .. } => (radius + height) * half_angle,
        }
    }

    /// Half its width at a distance from the middle.
    fn half_width(&self, x: f64) -> f64 {
        let Shape::Dumbbell = self.shape else { return self.section_mm()[0] / 2.0 };
        let [_, width, narrow_length, narrow, radius] = DUMBBELL;
        let beyond = (x.abs() - narrow_length / 2.0).max(0.0);
        // The fillet: a circle that touches the narrow part where it ends.
        let rise = if beyond < radius { radius - (radius * radius - beyond * beyond).sqrt() } else { radius };
        (narrow / 2.0 + rise).min(width / 2.0)
    }

    /// The point at a distance from the middle along the layer, one across, and a height above the bottom.
    fn place(&self, x: f64, y: f64, height: f64) -> Point3<f64> {
        match self.shape {
            Shape::Arc { radius, .. } => {
                let r = radius + height;
                let angle = x / r;
                Point3::new(r * angle.sin(), y, CROWN_MM - radius + r * angle.cos())
            }
            _ => Point3::new(x, y, height),
        }
    }

    /// The direction along the specimen at a point of it.
    pub fn along(&self, p: Point3<f64>) -> Vector3<f64> {
        match self.shape {
            Shape::Arc { radius, .. } => Vector3::new(p.z - (CROWN_MM - radius), 0.0, -p.x),
            _ => Vector3::x(),
        }
    }

    /// The surface at a height above the bottom, from end to end.
    pub fn surface(&self, height: f64) -> Mesh {
        self.sheet(self.half_length(height), &|x| self.half_width(x), height)
    }

    /// The strip of the surface on which the tape lies.
    pub fn strip(&self, height: f64) -> Mesh {
        let [length, width] = self.tape_mm;
        self.sheet(length / 2.0, &|_| width / 2.0, height)
    }

    /// How high an arc is that stands on its ends.
    pub fn standing_mm(&self) -> f64 {
        match self.shape {
            Shape::Arc { radius, half_angle, .. } => radius + self.section_mm()[1] - radius * half_angle.cos(),
            _ => self.section_mm()[1],
        }
    }

    /// The plane section of an arc at a height above its ends: between its two cylinders and its two end faces.
    pub fn section_at(&self, z: f64) -> Mesh {
        self.section_of(z, self.section_mm()[0])
    }

    /// The strip of that section on which a tape of the specimen's width has room.
    pub fn strip_at(&self, z: f64) -> Mesh {
        self.section_of(z, self.tape_mm[1])
    }

    fn section_of(&self, z: f64, width: f64) -> Mesh {
        let Shape::Arc { radius, half_angle, .. } = self.shape else {
            return Mesh { vertices: Vec::new(), triangles: Vec::new() };
        };
        let over = radius * half_angle.cos() + z;
        let chord = |r: f64| (r * r - over * over).max(0.0).sqrt();
        let (inner, outer) = (chord(radius), chord(radius + self.section_mm()[1]).min(over * half_angle.tan()));
        let half_width = |_: f64| width / 2.0;
        let place = |x: f64, y: f64| Point3::new(x, y, z);
        let mut parts = Vec::new();
        if inner <= 0.0 {
            parts.push(sheet([-outer, outer], &half_width, &place));
        } else if outer > inner {
            parts.extend([[-outer, -inner], [inner, outer]].map(|span| sheet(span, &half_width, &place)));
        }
        parts.into_iter().fold(Mesh { vertices: Vec::new(), triangles: Vec::new() }, joined)
    }

    /// The mould below an arc, which is wider and longer than it.
    pub fn mould(&self) -> Option<Mesh> {
        let Shape::Arc { radius, .. } = self.shape else { return None };
        let half = radius * MOULD_HALF_DEG.to_radians();
        Some(self.sheet(half, &|_| self.section_mm()[0], 0.0))
    }

    fn sheet(&self, half_length: f64, half_width: &dyn Fn(f64) -> f64, height: f64) -> Mesh {
        sheet([-half_length, half_length], half_width, &|x, y| self.place(x, y, height))
    }

    /// The closed solid.
    pub fn solid(&self) -> Mesh {
        closed(self.surface(0.0), self.surface(self.section_mm()[1]))
    }

    /// The mould as a closed solid on the plate.
    pub fn mould_solid(&self) -> Option<Mesh> {
        let top = self.mould()?;
        let down = |p: &Point3<f64>| Point3::new(p.x, p.y, 0.0);
        Some(closed(Mesh { vertices: top.vertices.iter().map(down).collect(), ..top.clone() }, top))
    }

    /// How high a point is above the bottom of the first layer; below 0 in the mould.
    pub fn height(&self, p: Point3<f64>) -> f64 {
        match self.shape {
            Shape::Arc { radius, .. } => p.x.hypot(p.z - (CROWN_MM - radius)) - radius,
            _ => p.z,
        }
    }
}

/// A sheet of quads from one end to the other, as wide as it is at each place.
fn sheet([from, to]: [f64; 2], half_width: &dyn Fn(f64) -> f64, place: &dyn Fn(f64, f64) -> Point3<f64>) -> Mesh {
    let columns = ((to - from) / STEP_MM).ceil().max(2.0) as u32;
    let mut vertices = Vec::new();
    for column in 0..=columns {
        let x = from + (to - from) * f64::from(column) / f64::from(columns);
        let across = |row: u32| half_width(x) * (2.0 * f64::from(row) / f64::from(ROWS) - 1.0);
        vertices.extend((0..=ROWS).map(|row| place(x, across(row))));
    }
    let mut triangles = Vec::new();
    for column in 0..columns {
        for row in 0..ROWS {
            let a = column * (ROWS + 1) + row;
            let b = a + ROWS + 1;
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    Mesh { vertices, triangles }
}

/// Two meshes as one, not connected.
pub fn joined(one: Mesh, other: Mesh) -> Mesh {
    let count = one.vertices.len() as u32;
    let others = other.triangles.iter().map(|corners| corners.map(|v| v + count));
    Mesh {
        triangles: one.triangles.iter().copied().chain(others).collect(),
        vertices: one.vertices.iter().chain(&other.vertices).copied().collect(),
    }
}

/// The solid between two sheets of the same rows and columns.
fn closed(bottom: Mesh, top: Mesh) -> Mesh {
    let count = bottom.vertices.len() as u32;
    let columns = count / (ROWS + 1) - 1;
    let mut triangles: Vec<[u32; 3]> = bottom.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    triangles.extend(top.triangles.iter().map(|corners| corners.map(|v| v + count)));
    let at = |column: u32, row: u32| column * (ROWS + 1) + row;
    let mut wall = |a: u32, b: u32| triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
    for column in 0..columns {
        wall(at(column, 0), at(column + 1, 0));
        wall(at(column + 1, ROWS), at(column, ROWS));
    }
    for row in 0..ROWS {
        wall(at(0, row + 1), at(0, row));
        wall(at(columns, row), at(columns, row + 1));
    }
    Mesh { vertices: bottom.vertices.into_iter().chain(top.vertices).collect(), triangles }
}
