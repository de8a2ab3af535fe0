//! An arm of the catalogue.

use crate::arm::model::ArmModel;

/// Who makes an arm: this decides how frames and joints are counted, and which programs it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Maker {
    /// ABB: RAPID.
    Abb,
    /// Fanuc: TP programs.
    Fanuc,
    /// KUKA: KRL.
    Kuka,
    /// Staubli: VAL 3.
    Staubli,
    /// Universal Robots: URScript.
    UniversalRobots,
    /// Yaskawa Motoman: INFORM.
    Yaskawa,
}

impl Maker {
    /// The name as the maker writes it, in ASCII.
    pub const fn name(self) -> &'static str {
        match self {
            Maker::Abb => "ABB",
            Maker::Fanuc => "Fanuc",
            Maker::Kuka => "KUKA",
            Maker::Staubli => "Staubli",
            Maker::UniversalRobots => "Universal Robots",
            Maker::Yaskawa => "Yaskawa Motoman",
        }
    }
}

/// An arm by its published numbers.
///
/// Base and flange are the frames in which the maker's controller counts with no tool and no user frame: `Arm::forward` is what the
/// pendant shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueArm {
    /// Its name in files.
    pub name: &'static str,
    /// Other names that find it. Case, spaces and punctuation do not count in any of them.
    pub aliases: &'static [&'static str],
    /// Who makes it.
    pub maker: Maker,
    /// What the maker calls it.
    pub title: &'static str,
    /// Its numbers.
    pub model: ArmModel,
    /// How far the mounting face is below the origin of the base frame, in millimetres: Fanuc, Staubli and Yaskawa have that at the
    /// height of axis 2.
    pub mount_below_base_mm: f64,
    /// Where the numbers are from.
    pub source: &'static str,
    /// What a user of this name should know.
    pub note: Option<&'static str>,
}
