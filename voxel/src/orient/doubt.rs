//! Where a mesh may be another part than its author's, with the volumes of both readings.

use super::OrientReport;
use std::fmt;

/// A way in which a mesh may be read otherwise than it was.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Doubt {
    /// Holes were closed, and so much volume depends on how that this is not beyond question.
    Holes {
        /// How many.
        holes: usize,
        /// Area of their mouths.
        mouths_mm2: f64,
        /// Volume with the holes closed.
        closed_mm3: f64,
        /// How much of that depends on how they are closed.
        uncertain_mm3: f64,
    },
    /// Bodies within others look outwards: taken as solid, though they may be meant as cavities.
    Shells {
        /// How many.
        shells: usize,
        /// Volume as taken.
        solid_mm3: f64,
        /// Volume if they are cavities.
        hollow_mm3: f64,
    },
    /// Whether a shell lies within another depends on how a hole of that is closed.
    Nesting {
        /// Volume as taken: holes closed across their rims.
        closed_mm3: f64,
        /// Volume by the winding number of the surface as it is.
        open_mm3: f64,
    },
    /// Open surfaces that bound no volume are not part of the solid.
    Sheets {
        /// How many.
        sheets: usize,
        /// Their area.
        area_mm2: f64,
    },
}

/// One line.
impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::Holes { holes, mouths_mm2, closed_mm3, uncertain_mm3 } => write!(
                f,
                "the surface is open: {holes} hole{} of {mouths_mm2:.1} mm2 in all {} closed, which makes a solid of \
                 {closed_mm3:.1} mm3 ({uncertain_mm3:.1} mm3 of it depend on how); as a surface without thickness it encloses 0 mm3",
                if *holes == 1 { "" } else { "s" },
                if *holes == 1 { "was" } else { "were" }
            ),
            Doubt::Shells { shells, solid_mm3, hollow_mm3 } => write!(
                f,
                "{} outward: filled, the part has {solid_mm3:.1} mm3, with cavities {hollow_mm3:.1} mm3",
                if *shells == 1 { "1 inner shell faces".to_owned() } else { format!("{shells} inner shells face") }
            ),
            Doubt::Nesting { closed_mm3, open_mm3 } => write!(
                f,
                "whether an inner shell is a cavity depends on how a hole is closed: {closed_mm3:.1} mm3 or {open_mm3:.1} mm3"
            ),
            Doubt::Sheets { sheets, area_mm2 } => write!(
                f,
                "{} nothing and {} not printed: {area_mm2:.1} mm2",
                match sheets {
                    1 => "1 surface without thickness encloses".to_owned(),
                    _ => format!("{sheets} surfaces without thickness enclose"),
                },
                if *sheets == 1 { "is" } else { "are" }
            ),
        }
    }
}

impl OrientReport {
    /// Where the mesh may be another part than its author's.
    ///
    /// # Arguments
    /// * `allowed`: share of the volume below which a difference is not worth a doubt, such as 1e-3.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{Doubt, nalgebra::Point3, orient};
    /// let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]].map(Point3::from);
    /// let closed = orient(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// assert!(closed.report.doubts(1e-3).is_empty());
    /// let open = orient(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2]])?;
    /// assert!(matches!(open.report.doubts(1e-3)[..], [Doubt::Holes { holes: 1, .. }]));
    /// # Ok::<(), curvlay_voxel::OrientError>(())
    /// ```
    pub fn doubts(&self, allowed: f64) -> Vec<Doubt> {
        let (volume, limit) = (self.volume_mm3, allowed * self.volume_mm3.abs());
        let mut doubts = Vec::new();
        if self.holes_mm3 > limit {
            let (holes, mouths_mm2, uncertain_mm3) = (self.holes, self.holes_mm2, self.holes_mm3);
            doubts.push(Doubt::Holes { holes, mouths_mm2, closed_mm3: volume, uncertain_mm3 });
        }
        if self.shells_mm3 > limit {
            let hollow_mm3 = volume - self.shells_mm3;
            doubts.push(Doubt::Shells { shells: self.shells, solid_mm3: volume, hollow_mm3 });
        }
        if (self.other_volume_mm3 - volume).abs() > limit {
            doubts.push(Doubt::Nesting { closed_mm3: volume, open_mm3: self.other_volume_mm3 });
        }
        if self.sheets > 0 {
            doubts.push(Doubt::Sheets { sheets: self.sheets, area_mm2: self.sheets_mm2 });
        }
        doubts
    }
}
