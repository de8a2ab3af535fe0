//! The six objects of the thesis on her three platforms.
//!
//! Objects 1 to 5 are flat, object 6 is not. The thesis shows them in figures only. The grids beside this file are
//! reconstructions from the numbers in its text, and how far these numbers fix a shape differs:
//! * object 1, a hook: as in the worked example of chapter 4, cell by cell;
//! * object 3, a T, and object 6, a square T in space: likely, they confirm each other;
//! * object 5, a wide arch: likely; object 4, a narrow one: a guess that fits;
//! * object 2: one of many shapes with these counts.
//!
//! The small platform is the foot of the object, the medium one reaches two cells beyond the object on each side, and
//! the large one is 35 cells wide; the thesis gives no sizes.

use curvlay_examples::args::Failure;
use curvlay_voxel::{TextGrid, read_text_grid};

/// The names of the platforms: small, medium, large.
pub const PLATFORMS: [&str; 3] = ["S", "M", "L"];

/// A line for each object, with the platforms S, M and L.
const TEXTS: [[&str; 3]; 6] = [
    [include_str!("object1_S.txt"), include_str!("object1.txt"), include_str!("object1_L.txt")],
    [include_str!("object2_S.txt"), include_str!("object2.txt"), include_str!("object2_L.txt")],
    [include_str!("object3_S.txt"), include_str!("object3.txt"), include_str!("object3_L.txt")],
    [include_str!("object4_S.txt"), include_str!("object4.txt"), include_str!("object4_L.txt")],
    [include_str!("object5_S.txt"), include_str!("object5.txt"), include_str!("object5_L.txt")],
    [include_str!("object6_S.txt"), include_str!("object6.txt"), include_str!("object6_L.txt")],
];

/// An object on a platform.
pub struct Drawing {
    /// 0 to 5 for the objects 1 to 6.
    pub object: usize,
    /// 0 to 2 for S, M and L.
    pub platform: usize,
    pub drawn: TextGrid,
}

impl Drawing {
    /// `object1_s`, to begin the name of a figure with.
    pub fn key(&self) -> String {
        format!("object{}_{}", self.object + 1, PLATFORMS[self.platform].to_lowercase())
    }
}

/// All objects on all platforms, object after object.
pub fn read() -> Result<Vec<Drawing>, Failure> {
    let texts = TEXTS.iter().flatten().enumerate();
    texts
        .map(|(at, text)| {
            let (object, platform) = (at / PLATFORMS.len(), at % PLATFORMS.len());
            let place = || format!("object {} on platform {}", object + 1, PLATFORMS[platform]);
            let drawn =
                read_text_grid(text.as_bytes()).map_err(|error| Failure::new(format!("{}: {error}", place())))?;
            Ok(Drawing { object, platform, drawn })
        })
        .collect()
}
