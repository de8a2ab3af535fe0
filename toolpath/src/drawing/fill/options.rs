//! How outlines are filled.

/// Where the outermost bead lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContourAt {
    /// Half a bead within the outline: the print is as wide as the design.
    #[default]
    Inside,
    /// On the outline, as in the thesis.
    OnLine,
}

/// How regions are filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fill {
    /// Outlines only.
    None,
    /// Scan lines within an outline.
    Lines,
    /// Loops, each a stroke of its own.
    Concentric,
    /// Loops joined into one curve.
    #[default]
    Spiral,
}

/// How a design is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillOptions {
    /// Wanted width of a bead, in millimetres, from 0.0001 to 1000. Default 3.2, which the thesis reaches with its last motor (section 6.4.2).
    pub bead: f64,
    /// Where the outermost bead lies. Default: within the outline.
    pub contour: ContourAt,
    /// How regions are filled. Default: a spiral.
    pub fill: Fill,
    /// Direction of scan lines, from x, in radians. Default 0; the thesis has 0 and a quarter turn.
    pub angle: f64,
    /// Whether scan lines are joined. Default: yes; the thesis does not.
    pub zigzag: bool,
    /// Distance of scan lines from the bead of the outline, as a share of the bead, in addition to half a bead. Default 0. The
    /// thesis removes points that are too near, with a threshold found by trial.
    pub gap: f64,
    /// Narrowest bead, as a share of the wanted one; narrower regions are left out. Default 0.5.
    pub min_width: f64,
    /// How far a bead may be from where it is meant, in millimetres, from 0.0001 to a bead. Default 0.01.
    pub tolerance: f64,
}

impl Default for FillOptions {
    fn default() -> Self {
        FillOptions {
            bead: 3.2,
            contour: ContourAt::Inside,
            fill: Fill::Spiral,
            angle: 0.0,
            zigzag: true,
            gap: 0.0,
            min_width: 0.5,
            tolerance: 0.01,
        }
    }
}
