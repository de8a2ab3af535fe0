//! Patches of a fault, gathered to places.

use super::super::figures::Place;
use super::patches::Patch;
use std::collections::BTreeMap;

/// Edge of the boxes in which patches of a layer are one place, in millimetres.
const LUMP_MM: f64 = 4.0;

/// A fault.
#[derive(Default)]
pub struct Regions {
    /// Area of all of it.
    pub area: f64,
    lumps: BTreeMap<(u32, [i64; 3]), Place>,
}

impl Regions {
    /// Faults of patches: each with how bad it is, if it is. With `adds` a place is as bad as its patches together, else as the worst.
    pub fn of<'a>(faults: impl Iterator<Item = (&'a Patch, Option<f64>)>, adds: bool) -> Self {
        let mut regions = Regions::default();
        for (patch, size) in faults.filter_map(|(patch, size)| Some((patch, size?))) {
            let at = patch.middle();
            regions.area += patch.area;
            let lump = [at.x, at.y, at.z].map(|c| (c / LUMP_MM).floor() as i64);
            let new = Place { at, layer: Some(patch.number), size };
            let place = regions.lumps.entry((patch.rank, lump)).or_insert(Place { size: 0.0, ..new });
            if adds {
                place.size += size;
            } else if size > place.size {
                *place = new;
            }
        }
        regions
    }

    /// The places, in the order of the build.
    pub fn places(self) -> Vec<Place> {
        self.lumps.into_values().collect()
    }
}
