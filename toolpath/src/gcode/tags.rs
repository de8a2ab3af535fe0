//! Comments by which viewers show layers and kinds of beads, as slicers write them.
//!
//! PrusaSlicer 2.x: `;LAYER_CHANGE`, `;Z:`, `;HEIGHT:`, `;TYPE:External perimeter`, `;WIDTH:`. CuraEngine: `;LAYER:0`,
//! `;TYPE:WALL-OUTER`. No firmware acts on them.

use super::text::Text;
use crate::path::BeadKind;

/// How a file names layers and kinds of beads for viewers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Tags {
    /// Not at all.
    None,
    /// As PrusaSlicer and its relatives do.
    #[default]
    Prusa,
    /// As CuraEngine does. The file names it in a comment, by which viewers know these tags.
    Cura,
}

/// What comes next in a file. No machine acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// A layer begins.
    Layer {
        /// Which one, from 0.
        number: u32,
        /// Where its first bead begins: z of the tip in the part, -1e6 to 1e6 mm.
        z_mm: f64,
        /// Its thickness there, 0 to 1e6 mm.
        height_mm: f64,
    },
    /// The beads that follow, until the next mark of this kind.
    Bead {
        /// What they are for.
        kind: BeadKind,
        /// Their width, 0 to 1e6 mm.
        width_mm: f64,
        /// Their height, 0 to 1e6 mm.
        height_mm: f64,
    },
}

/// Digits of widths and heights behind the point.
const DECIMALS: usize = 3;

/// Tags that a file has by now.
#[derive(Debug, Default)]
pub(super) struct Tagged {
    kind: Option<&'static str>,
    /// Width and height as written.
    size: [Option<f64>; 2],
}

impl Tags {
    /// The comment that a file begins with, if viewers need one.
    pub(super) fn title(self) -> Option<&'static str> {
        match self {
            Tags::Cura => Some(";FLAVOR:Marlin\n; tags of layers and beads as Cura_SteamEngine writes them"),
            _ => None,
        }
    }

    fn name(self, kind: BeadKind) -> &'static str {
        match (self, kind) {
            (Tags::Cura, BeadKind::Support | BeadKind::SparseSupport | BeadKind::SupportBridge) => "SUPPORT",
            (_, BeadKind::Support | BeadKind::SparseSupport | BeadKind::SupportBridge) => "Support material",
            (Tags::Cura, BeadKind::Wall) => "WALL-OUTER",
            (Tags::Cura, BeadKind::Solid | BeadKind::Skin | BeadKind::Bridge) => "SKIN",
            (Tags::Cura, BeadKind::Infill) => "FILL",
            (_, BeadKind::Wall) => "External perimeter",
            (_, BeadKind::Solid) => "Solid infill",
            (_, BeadKind::Skin) => "Top solid infill",
            (_, BeadKind::Bridge) => "Bridge infill",
            (_, BeadKind::Infill) => "Internal infill",
        }
    }
}

impl Tagged {
    /// Appends what a mark says that the file does not have yet. Returns the number of lines.
    pub fn write(&mut self, tags: Tags, mark: &Mark, text: &mut Text) -> u64 {
        let before = text.0.len();
        match (tags, *mark) {
            (Tags::None, _) => {}
            (Tags::Cura, Mark::Layer { number, .. }) => {
                text.steps_of(";LAYER:", i64::from(number)).word("\n");
            }
            (Tags::Prusa, Mark::Layer { z_mm, height_mm, .. }) => {
                text.word(";LAYER_CHANGE\n").number(";Z:", z_mm, DECIMALS).word("\n");
                self.size(1, ";HEIGHT:", height_mm, text);
            }
            (_, Mark::Bead { kind, width_mm, height_mm }) => {
                let name = tags.name(kind);
                if self.kind != Some(name) {
                    self.kind = Some(name);
                    text.word(";TYPE:").word(name).word("\n");
                }
                if tags == Tags::Prusa {
                    self.size(0, ";WIDTH:", width_mm, text);
                    self.size(1, ";HEIGHT:", height_mm, text);
                }
            }
        }
        // What was there before may be a whole block of a file.
        text.0[before..].iter().filter(|&&byte| byte == b'\n').count() as u64
    }

    fn size(&mut self, which: usize, name: &str, value: f64, text: &mut Text) {
        if self.size[which] != Some(value) {
            self.size[which] = Some(value);
            text.number(name, value, DECIMALS).word("\n");
        }
    }
}
