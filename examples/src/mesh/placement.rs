//! From the units and axes of a file to millimetres with z up.

use super::{Mesh, MeshFault};
use clap::ValueEnum;
use nalgebra::Point3;

/// The unit of the numbers in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// Millimetres.
    #[default]
    Mm,
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
}

impl Default for Placement {
    fn default() -> Self {
        Placement { unit: Unit::Mm, scale: 1.0, up: Up::Z }
    }
}

/// Longest side below which a part is taken for one in another unit, in mm: the smallest thing anyone prints with a
/// nozzle is larger, and a hand-sized part in metres is smaller.
const SMALL: f64 = 2.0;
/// Longest side above which the unit is doubted, in mm: ten metres are beyond any robot of ours.
const LARGE: f64 = 10_000.0;

impl Placement {
    /// Turns and scales `mesh`.
    ///
    /// # Returns
    /// A warning, in one line, when the size says that the unit is wrong.
    ///
    /// # Errors
    /// [`MeshFault::Scale`] when a coordinate becomes infinite.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::mesh::{Placement, Unit, Up};
    /// use curvlay_examples::shapes::jug;
    /// let mut mesh = jug();
    /// let height = |m: &curvlay_examples::mesh::Mesh| m.bounds().map_or(0.0, |[low, high]| high.z - low.z);
    /// let before = height(&mesh);
    /// let warning = Placement { unit: Unit::In, scale: 2.0, up: Up::Z }.apply(&mut mesh)?;
    /// assert_eq!(warning, None);
    /// assert!((height(&mesh) / before - 50.8).abs() < 1e-12);
    /// # Ok::<(), curvlay_examples::mesh::MeshFault>(())
    /// ```
    pub fn apply(&self, mesh: &mut Mesh) -> Result<Option<String>, MeshFault> {
        let factor = self.unit.millimetres() * self.scale;
        for p in &mut mesh.vertices {
            let turned = match self.up {
                Up::X => [0.0 - p.z, p.y, p.x],
                Up::Y => [p.x, 0.0 - p.z, p.y],
                Up::Z => [p.x, p.y, p.z],
            };
            *p = Point3::from(turned.map(|c| c * factor));
        }
        let Some([low, high]) = mesh.bounds() else { return Ok(None) };
        let size = high - low;
        if !size.iter().all(|side| side.is_finite()) {
            return Err(MeshFault::Scale);
        }
        Ok(self.doubt(size.max()))
    }

    fn doubt(&self, longest: f64) -> Option<String> {
        let found = format!("the longest side of the part is {} mm", significant(longest));
        if longest < SMALL && self.unit == Unit::Mm {
            Some(format!("{found}: is it in metres or inches? use --unit m or --unit in"))
        } else if longest < SMALL {
            Some(format!("{found}: is the scale right?"))
        } else if longest > LARGE && self.unit != Unit::Mm {
            Some(format!("{found}: is it in millimetres? leave --unit out"))
        } else if longest > LARGE {
            Some(format!("{found}: is the scale right?"))
        } else {
            None
        }
    }
}

/// A length with four figures.
fn significant(value: f64) -> String {
    if value <= 0.0 || (1e-3..1e6).contains(&value) {
        let digits = if value <= 0.0 { 0 } else { (3 - value.log10().floor() as i32).max(0) as usize };
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.3e}")
    }
}
