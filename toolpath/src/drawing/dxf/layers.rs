//! The table of layers: which of them are off or frozen.

use super::pair::Record;
use std::collections::BTreeMap;

/// Why a layer is not shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hidden {
    /// What lies on it is not shown.
    Off,
    /// Nor is what is inserted on it, whatever layers that is on.
    Frozen,
}

impl Hidden {
    pub fn name(self) -> &'static str {
        match self {
            Hidden::Off => "off",
            Hidden::Frozen => "frozen",
        }
    }
}

/// The layers that are not shown. Names are equal without regard to case, as CAD programs take them.
#[derive(Clone, Debug, Default)]
pub(super) struct HiddenLayers(BTreeMap<String, Hidden>);

impl HiddenLayers {
    /// Takes a LAYER of the table: bit 1 of its flags freezes it, a negative colour turns it off.
    pub fn read(&mut self, layer: &Record) {
        // Invalid numbers say nothing about the layer.
        let frozen = layer.whole_or(70, 0).is_ok_and(|flags| flags & 1 == 1);
        let off = layer.whole_or(62, 7).is_ok_and(|colour| colour < 0);
        let hidden = if frozen { Some(Hidden::Frozen) } else { off.then_some(Hidden::Off) };
        if let Some(hidden) = hidden {
            self.0.insert(layer.text(2).to_lowercase(), hidden);
        }
    }

    pub fn get(&self, layer: &str) -> Option<Hidden> {
        if self.0.is_empty() { None } else { self.0.get(&layer.to_lowercase()).copied() }
    }
}
