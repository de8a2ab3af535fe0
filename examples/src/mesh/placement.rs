//! From the units and axes of a file to millimetres with z up.

use super::fault::{LARGE_MM, MeshFault, significant};
use super::triangles::Mesh;
use clap::ValueEnum;
use nalgebra::{Point3, Vector3};

/// The unit of the numbers in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// Millimetres.
    #[default]
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
}

impl Unit {
    /// Millimetres in one of these.
    pub fn millimetres(self) -> f64 {
        match self {
            Unit::Mm => 1.0,
            Unit::Cm => 10.0,
            Unit::M => 1000.0,
            Unit::In => 25.4,
        }
    }
}

/// The axis of a file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Up {
    /// A quarter turn about y brings x up.
    X,
    /// As in most animation programs; a quarter turn about x brings y up.
    Y,
    /// Nothing to turn.
    #[default]
    Z,
    /// A quarter turn about y brings -x up.
    #[value(name = "-x")]
    NegX,
    /// A quarter turn about x brings -y up.
    #[value(name = "-y")]
    NegY,
    /// A half turn about x: the part stands on its head.
    #[value(name = "-z")]
    NegZ,
}

impl Up {
    /// A vector of the file, turned. Zero stays zero, without a sign.
    pub fn turned(self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = v;
        match self {
            Up::X => [0.0 - z, y, x],
            Up::Y => [x, 0.0 - z, y],
            Up::Z => [x, y, z],
            Up::NegX => [z, y, 0.0 - x],
            Up::NegY => [x, z, 0.0 - y],
            Up::NegZ => [x, 0.0 - y, 0.0 - z],
        }
    }

    /// A vector turned back, as the file has it.
    pub fn back(self, v: [f64; 3]) -> [f64; 3] {
        let inverse = match self {
            Up::X => Up::NegX,
            Up::NegX => Up::X,
            Up::Y => Up::NegY,
            Up::NegY => Up::Y,
            Up::Z | Up::NegZ => self,
        };
        inverse.turned(v)
    }
}

/// How a mesh is brought to millimetres with z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Unit of the numbers.
    pub unit: Unit,
    /// A factor on top of the unit, above zero.
    pub scale: f64,
    /// The axis that points up.
    pub up: Up,
    /// Whether a part may be larger than [`LARGE_MM`].
    pub allow_large: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { unit: Unit::Mm, scale: 1.0, up: Up::Z, allow_large: false }
    }
}

/// Longest side below which a part whose unit was not named is taken for one in another, in mm: a part of 300 mm has 12
/// inches, and 0.3 metres.
const SMALL_MM: f64 = 12.0;
/// The same where the unit was named: less is hardly anything to a nozzle.
const SMALL_WITH_UNIT_MM: f64 = 2.0;
/// Longest side above which a unit that was named is doubted, in mm: a part of 80 mm read in inches, of 2 mm in metres.
const DOUBTED_MM: f64 = 2_000.0;

impl Placement {
    /// A place of the file, turned and scaled, in millimetres.
    pub fn place(&self, place: [f64; 3]) -> Point3<f64> {
        Point3::from(self.up.turned(place)) * (self.unit.millimetres() * self.scale)
    }

    /// A place in millimetres, as the file has it: the inverse of [`Placement::place`].
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::mesh::{Placement, Unit, Up};
    /// for up in [Up::X, Up::Y, Up::Z, Up::NegX, Up::NegY, Up::NegZ] {
    ///     let placement = Placement { unit: Unit::Cm, scale: 0.5, up, ..Placement::default() };
    ///     assert_eq!(placement.of_file(placement.place([1.0, 2.0, -4.0])), [1.0, 2.0, -4.0]);
    /// }
    /// ```
    pub fn of_file(&self, place: Point3<f64>) -> [f64; 3] {
        self.up.back((place / (self.unit.millimetres() * self.scale)).into())
    }

    /// Turns and scales `mesh`. A part farther than [`LARGE_MM`] from the origin is moved there, its middle over it in x
    /// and y and its lowest point at z = 0: before scaling, so that no digit is lost.
    ///
    /// # Returns
    /// Warnings, each in one line: when the size says that the unit is wrong, and when the part was moved.
    ///
    /// # Errors
    /// [`MeshFault::Scale`] when a coordinate becomes infinite, [`MeshFault::TooLarge`] for a part larger than
    /// [`LARGE_MM`] unless that is allowed.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::mesh::{Placement, Unit};
    /// use curvlay_examples::shapes::jug;
    /// let mut mesh = jug();
    /// let height = |m: &curvlay_examples::mesh::Mesh| m.bounds().map_or(0.0, |[low, high]| high.z - low.z);
    /// let before = height(&mesh);
    /// let placement = Placement { unit: Unit::In, scale: 0.1, ..Placement::default() };
    /// assert!(placement.apply(&mut mesh)?.is_empty());
    /// assert!((height(&mesh) / before - 2.54).abs() < 1e-12);
    /// # Ok::<(), curvlay_examples::mesh::MeshFault>(())
    /// ```
    pub fn apply(&self, mesh: &mut Mesh) -> Result<Vec<String>, MeshFault> {
        let factor = self.unit.millimetres() * self.scale;
        for p in &mut mesh.vertices {
            *p = Point3::from(self.up.turned([p.x, p.y, p.z]));
        }
        let Some([low, high]) = mesh.bounds() else { return Ok(Vec::new()) };
        let longest_mm = (high - low).max() * factor;
        if !longest_mm.is_finite() {
            return Err(MeshFault::Scale);
        }
        if longest_mm > LARGE_MM && !self.allow_large {
            return Err(MeshFault::TooLarge { longest_mm });
        }
        let mut warnings = Vec::from_iter(self.doubt(longest_mm));
        let middle = nalgebra::center(&low, &high);
        let farthest_mm = middle.x.abs().max(middle.y.abs()).max(low.z.abs()) * factor;
        let mut seat = Vector3::zeros();
        if farthest_mm > LARGE_MM.max(longest_mm) {
            seat = Vector3::new(middle.x, middle.y, low.z);
            warnings.push(format!("the part lay {} mm from the origin: it was moved there", significant(farthest_mm)));
        }
        mesh.vertices.iter_mut().for_each(|p| *p = (*p - seat) * factor);
        if mesh.vertices.iter().flat_map(Point3::iter).any(|c| !c.is_finite()) {
            return Err(MeshFault::Scale);
        }
        Ok(warnings)
    }

    fn doubt(&self, longest: f64) -> Option<String> {
        let found = format!("the longest side of the part is {} mm", significant(longest));
        match self.unit {
            Unit::Mm if longest < SMALL_MM => {
                Some(format!("{found}: is it in centimetres, metres or inches? use --unit cm, m or in"))
            }
            Unit::Cm | Unit::M | Unit::In if longest < SMALL_WITH_UNIT_MM => {
                Some(format!("{found}: is the scale right?"))
            }
            Unit::Cm | Unit::M | Unit::In if longest > DOUBTED_MM => {
                Some(format!("{found}: is it in millimetres? leave --unit out"))
            }
            _ => None,
        }
    }
}
