//! What came of it.

use super::collisions::Study;
use super::planning::Planned;
use curvlay_examples::viewer::Model;
use curvlay_trajectory::TimedPath;

/// A robot's motions over the path, and over a noisy one for each level of noise.
pub struct Run<const N: usize> {
    /// `ur3` or `cell8`.
    pub robot: &'static str,
    /// A motion for each method.
    pub planned: Vec<Planned<N>>,
    /// What there is no motion for, in words.
    pub notes: Vec<String>,
    /// Degrees of noise, and the motions there.
    pub noisy: Vec<(u32, Vec<Planned<N>>)>,
    /// The smoothest motion, to be played.
    pub shown: Option<Model>,
}

/// All that came out.
pub struct Results {
    /// The path in pieces.
    pub path: TimedPath,
    /// Waypoints that were given.
    pub given: usize,
    /// With the part in the hand of a UR3.
    pub ur3: Option<Run<6>>,
    /// With eight axes.
    pub cell8: Option<Run<8>>,
    /// Collisions on the UR3.
    pub study: Option<Study>,
}
