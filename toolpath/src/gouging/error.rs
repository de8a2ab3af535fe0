//! Why gouging is not looked for.

/// Why gouging is not looked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GougingError {
    /// An option is out of its range.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// A path names a layer that is not there, or comes after one of a later layer.
    #[error("path {path} is on layer {layer}: there are {layers}, and paths follow them in order")]
    Layer {
        /// The path, from 0.
        path: usize,
        /// Its layer.
        layer: u32,
        /// Layers that there are.
        layers: usize,
    },
    /// A waypoint that is not finite.
    #[error("waypoint {waypoint} of path {path} is not finite or has no unit direction")]
    BadWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// A path without a second waypoint.
    #[error("path {path} has {waypoints} waypoints: it needs two")]
    FewWaypoints {
        /// The path, from 0.
        path: usize,
        /// Its waypoints.
        waypoints: usize,
    },
    /// More waypoints than can be numbered.
    #[error("{waypoints} waypoints are too many: at most 2^31")]
    TooLarge {
        /// All waypoints.
        waypoints: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}
