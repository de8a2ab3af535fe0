//! Which layers carry tape, and what the tapes do to the height of the layers above.
//!
//! Dai 2020, section 5.3.1: a layer of thermoplastic is the substrate of the tapes, and one on top of them embeds them. There no
//! compensation is taken, since tapes (0.08 mm) are thin beside layers (0.3 to 0.6 mm), and layers are even offsets of each other. Here the
//! offset is an option: each layer that carries tape raises those above it by the same amount.

use crate::orientation::ToolPath;

/// How layers and tapes alternate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct SandwichOptions {
    /// Layers of thermoplastic below the first tapes, at least 1, their substrate: 1.
    pub base: u32,
    /// From one layer that carries tape to the next, at least 1: 1, each of them.
    pub every: u32,
    /// Layers of thermoplastic on the last tapes, at least 1, which embed them: 1.
    pub cover: u32,
    /// How far a layer that carries tape raises all that is above it, in millimetres, 0 to 10: 0, as in the dissertation. The thickness of
    /// the tape compensates it in full.
    pub offset: f64,
}

impl Default for SandwichOptions {
    fn default() -> Self {
        SandwichOptions { base: 1, every: 1, cover: 1, offset: 0.0 }
    }
}

/// A layer of the schedule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SandwichLayer {
    /// Whether tape is laid on it.
    pub carries_tape: bool,
    /// How far it is raised by the tapes below, along its normal, in millimetres.
    pub raised: f64,
}

/// Why there is no schedule.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SandwichError {
    /// A number of layers that must be at least 1.
    #[error("`{option}` is 0: tapes lie between thermoplastic, so it must be 1 or more")]
    Zero {
        /// Its name.
        option: &'static str,
    },
    /// An offset that no tape has.
    #[error("`offset` is {offset}: it must be from 0 to 10 mm")]
    Offset {
        /// What was given.
        offset: f64,
    },
    /// A layer that cannot carry tapes: there is no such layer, or it is the last one.
    #[error("tapes on layer {} of {layers}: it must be from 1 to {}, so that a layer covers them", u64::from(*layer) + 1, layers.saturating_sub(1))]
    NoSuchLayer {
        /// The layer, from 0.
        layer: u32,
        /// Layers of the part.
        layers: u32,
    },
    /// Nothing is between base and cover.
    #[error("{layers} layers carry no tape: {base} below and {cover} above it are {} already", base + cover)]
    TooFew {
        /// Layers of the part.
        layers: u32,
        /// Layers below the first tapes.
        base: u32,
        /// Layers above the last.
        cover: u32,
    },
    /// A path of a layer that the schedule does not have.
    #[error("path {path} is of layer {layer}, but the schedule has {layers} layers")]
    Layer {
        /// The path, from 0.
        path: usize,
        /// Its layer, from 0.
        layer: u32,
        /// Layers of the schedule.
        layers: usize,
    },
}

/// Most that a layer of tape may raise those above, in millimetres: a thicker tape is an error.
const MAX_OFFSET: f64 = 10.0;

/// The schedule of a part: the first tapes lie on layer `base` (counted from 1), then on each `every`th one, and `cover` layers stay on top.
///
/// # Arguments
/// * `layers`: how many the part has.
///
/// # Errors
/// [`SandwichError`]. It is an error if no layer carries tapes.
///
/// # Cost
/// `O(n)` for `n` layers.
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::sandwich::{SandwichOptions, sandwich};
/// // The curved specimens of the dissertation: seven layers, six of them with tape on top.
/// let schedule = sandwich(7, &SandwichOptions { offset: 0.08, ..SandwichOptions::default() })?;
/// assert_eq!(schedule.iter().filter(|layer| layer.carries_tape).count(), 6);
/// assert!((schedule[6].raised - 6.0 * 0.08).abs() < 1e-12);
/// # Ok::<(), curvlay_toolpath::fiber::sandwich::SandwichError>(())
/// ```
pub fn sandwich(layers: u32, options: &SandwichOptions) -> Result<Vec<SandwichLayer>, SandwichError> {
    let SandwichOptions { base, every, cover, offset } = *options;
    for (option, number) in [("base", base), ("every", every), ("cover", cover)] {
        if number == 0 {
            return Err(SandwichError::Zero { option });
        }
    }
    if !(0.0..=MAX_OFFSET).contains(&offset) {
        return Err(SandwichError::Offset { offset });
    }
    let end = layers.saturating_sub(cover);
    if base > end {
        return Err(SandwichError::TooFew { layers, base, cover });
    }
    let carries = |layer: u32| layer + 1 >= base && layer < end && (layer + 1 - base).is_multiple_of(every);
    Ok(scheduled(layers, carries, offset))
}

/// The schedule of a part whose layers with tapes are chosen one by one.
///
/// # Arguments
/// * `layers`: how many the part has; `carrying`: those that carry tapes, from 0, in any order; twice is once.
/// * `offset`: as [`SandwichOptions::offset`].
///
/// # Errors
/// [`SandwichError::NoSuchLayer`] for a layer that is not there or has none above it, [`SandwichError::Offset`].
///
/// # Cost
/// `O(n + m log m)` for `n` layers and `m` with tapes.
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::sandwich::{SandwichError, sandwich_on};
/// let schedule = sandwich_on(5, &[3, 1], 0.08)?;
/// let carrying: Vec<bool> = schedule.iter().map(|layer| layer.carries_tape).collect();
/// assert_eq!(carrying, [false, true, false, true, false]);
/// assert!((schedule[4].raised - 2.0 * 0.08).abs() < 1e-12);
/// // Nothing would cover tapes on the last layer.
/// assert_eq!(sandwich_on(5, &[4], 0.0), Err(SandwichError::NoSuchLayer { layer: 4, layers: 5 }));
/// # Ok::<(), SandwichError>(())
/// ```
pub fn sandwich_on(layers: u32, carrying: &[u32], offset: f64) -> Result<Vec<SandwichLayer>, SandwichError> {
    if !(0.0..=MAX_OFFSET).contains(&offset) {
        return Err(SandwichError::Offset { offset });
    }
    if let Some(&layer) = carrying.iter().find(|layer| layer.saturating_add(1) >= layers) {
        return Err(SandwichError::NoSuchLayer { layer, layers });
    }
    let mut carrying = carrying.to_vec();
    carrying.sort_unstable();
    carrying.dedup();
    Ok(scheduled(layers, |layer| carrying.binary_search(&layer).is_ok(), offset))
}

/// Layers with what raises them.
fn scheduled(layers: u32, carries: impl Fn(u32) -> bool, offset: f64) -> Vec<SandwichLayer> {
    let mut below = 0u32;
    let layer = |number: u32| {
        let layer = SandwichLayer { carries_tape: carries(number), raised: f64::from(below) * offset };
        below += u32::from(layer.carries_tape);
        layer
    };
    (0..layers).map(layer).collect()
}

/// Raises tool paths by what their layer is raised, along the direction of each waypoint.
///
/// # Errors
/// [`SandwichError::Layer`] for a path that is of no layer of the schedule; then nothing is changed.
///
/// # Cost
/// `O(n)` for `n` waypoints.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::sandwich::{SandwichOptions, raise, sandwich};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// let axis = Vector3::z_axis();
/// let at = |x| Waypoint { position: Point3::new(x, 0.0, 1.2), axis, width: 0.8, height: 0.6, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Solid };
/// let mut paths = [ToolPath { layer: 1, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0)] }];
/// raise(&mut paths, &sandwich(3, &SandwichOptions { offset: 0.08, ..SandwichOptions::default() })?)?;
/// assert!((paths[0].waypoints[1].position.z - 1.28).abs() < 1e-12);
/// # Ok::<(), curvlay_toolpath::fiber::sandwich::SandwichError>(())
/// ```
pub fn raise(paths: &mut [ToolPath], schedule: &[SandwichLayer]) -> Result<(), SandwichError> {
    if let Some((path, of)) = paths.iter().enumerate().find(|(_, path)| path.layer as usize >= schedule.len()) {
        return Err(SandwichError::Layer { path, layer: of.layer, layers: schedule.len() });
    }
    for path in paths {
        let raised = schedule[path.layer as usize].raised;
        path.waypoints.iter_mut().for_each(|waypoint| waypoint.position += waypoint.axis.into_inner() * raised);
    }
    Ok(())
}
