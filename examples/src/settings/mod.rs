//! The settings of a print: on the command line, and as a profile in a JSON file. Both have the same names and the same rules, as each
//! setting is declared once, in [`Settings`].
//!
//! What is set nowhere has the default of the crates' options, but for the layer height and the width of a bead, which only the user
//! of a printer knows: [`LAYER_HEIGHT_MM`] and [`BEAD_MM`].

mod declared;
mod flavour;
mod library;
mod profile;
mod rules;

pub use declared::{
    BEAD_MM, Count, FILES, LAYER_HEIGHT_MM, LAYERS, MACHINE, MATERIAL, PLATFORM_DIAMETER_MM, SPEEDS, Settings, Sparse,
    TagStyle, Words,
};
pub use flavour::{flavour_names, named_flavour};
pub use profile::Profile;
pub use rules::{default_nozzle, nozzle};
