//! What the platform stands on decides how large it is.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), section 6.4: three ways to set up an arm, and what each
//! means for the platform that counts into the hull.

use clap::ValueEnum;
use curvlay_layers::curved::{Platform, PlatformError};
use curvlay_voxel::TextGrid;

/// How far the floor reaches beyond the drawn platform on each side, in cells: some ten times the height of the objects of the
/// thesis, which gives no number. The farther it reaches, the flatter are the layers that are left.
pub const FLOOR: u32 = 100;

/// Who holds what, and where the platform is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Hardware {
    /// The platform in the hand, under a fixed nozzle (Fig. 6.7): it is as drawn
    InHand,
    /// The nozzle in the hand, the platform on the floor (Fig. 6.8): the floor counts as platform
    Fixed,
    /// The nozzle in the hand, the platform raised above the floor (Fig. 6.9): it is as drawn, with nothing around it
    Elevated,
}

impl Hardware {
    /// All of them, in the order of Table 6.7.
    pub const ALL: [Hardware; 3] = [Hardware::InHand, Hardware::Fixed, Hardware::Elevated];

    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Hardware::InHand => "platform in the hand",
            Hardware::Fixed => "nozzle in the hand, platform on the floor",
            Hardware::Elevated => "nozzle in the hand, platform elevated",
        }
    }

    /// Begins the names of its figures.
    pub fn key(self) -> &'static str {
        match self {
            Hardware::InHand => "in_hand",
            Hardware::Fixed => "fixed",
            Hardware::Elevated => "elevated",
        }
    }

    /// Cells by which the platform is wider than drawn, on each side.
    fn wider(self) -> u32 {
        if self == Hardware::Fixed { FLOOR } else { 0 }
    }

    /// Cells of the platform along x.
    pub fn width(self, drawn: &TextGrid) -> u32 {
        let xs = drawn.platform.iter().map(|cell| cell[0]);
        let (first, last) = xs.fold((u32::MAX, 0), |(first, last), x| (first.min(x), last.max(x)));
        last + 1 - first + 2 * self.wider()
    }

    /// The platform by the rules of the thesis: the hull of its cells' centres, a thin plate half a cell below the plane
    /// `z = 0`.
    pub fn platform_of_thesis(self, drawn: &TextGrid) -> Result<Platform, PlatformError> {
        let wider = f64::from(self.wider());
        hull(drawn, [0.5 - wider, 0.5 + wider])?.elevated(-1)
    }

    /// The platform by our rules: its top is under the part, its corners are those of the cells. It reaches down without
    /// end, but for one that stands free.
    pub fn platform_of_ours(self, drawn: &TextGrid) -> Result<Platform, PlatformError> {
        let wider = f64::from(self.wider());
        let platform = hull(drawn, [-wider, 1.0 + wider])?;
        if self == Hardware::Elevated { platform.elevated(0) } else { Ok(platform) }
    }
}

/// The hull of the platform's cells, of which each reaches from `low` to `high`.
fn hull(drawn: &TextGrid, [low, high]: [f64; 2]) -> Result<Platform, PlatformError> {
    let along = |axis: usize| drawn.platform.iter().map(move |cell| f64::from(cell[axis]));
    if drawn.flat {
        let (first, last) = along(0).fold((f64::MAX, f64::MIN), |(first, last), x| (first.min(x), last.max(x)));
        return Platform::segment(first + low, last + high);
    }
    let corners = along(0)
        .zip(along(1))
        .flat_map(|(x, y)| [[x + low, y + low], [x + high, y + low], [x + high, y + high], [x + low, y + high]]);
    Platform::polygon(&corners.collect::<Vec<_>>())
}
