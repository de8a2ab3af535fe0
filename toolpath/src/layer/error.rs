//! Why layers, or what is there before them, cannot be used.

/// Why layers cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StackError {
    /// More than can be numbered.
    #[error("{triangles} triangles are too many: at most 2^30")]
    TooLarge {
        /// All triangles.
        triangles: usize,
    },
    /// A vertex of a surface has an invalid coordinate.
    #[error("vertex {vertex} of layer {layer} is not finite or beyond 1e7 mm")]
    BadVertex {
        /// The layer, from 0.
        layer: usize,
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A triangle names a point that is not there.
    #[error("triangle {triangle} of layer {layer} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// The layer, from 0.
        layer: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// Vertices that the layer has.
        vertices: usize,
    },
    /// There is not one spacing for each triangle.
    #[error("layer {layer} has {spacing} spacings for {triangles} triangles")]
    SpacingCount {
        /// The layer, from 0.
        layer: usize,
        /// Spacings given.
        spacing: usize,
        /// Triangles given.
        triangles: usize,
    },
    /// A layer without thickness.
    #[error("triangle {triangle} of layer {layer} has a spacing of {spacing} mm: it must be above 0 and below 1e7")]
    BadSpacing {
        /// The layer, from 0.
        layer: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The spacing.
        spacing: f64,
    },
    /// A curve needs two points, a closed one three.
    #[error("curve {curve} of layer {layer} has {points} points: a curve needs two, a closed one three")]
    FewPoints {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// Points that it has.
        points: usize,
    },
    /// All points of a curve are one.
    #[error("curve {curve} of layer {layer} has no length")]
    NoLength {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
    },
    /// There is not one width for each point.
    #[error("curve {curve} of layer {layer} has {widths} widths for {points} points")]
    WidthCount {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// Widths given.
        widths: usize,
        /// Points given.
        points: usize,
    },
    /// A point of a curve has an invalid coordinate.
    #[error("point {point} of curve {curve} of layer {layer} is not finite or beyond 1e7 mm")]
    BadPoint {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// The point, from 0.
        point: usize,
    },
    /// A bead without width.
    #[error(
        "point {point} of curve {curve} of layer {layer} has a width of {width} mm: it must be above 0 and below 1e7"
    )]
    BadWidth {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// The point, from 0.
        point: usize,
        /// The width.
        width: f64,
    },
    /// A curve on a layer without any triangle that has an area: there is no thickness and no normal.
    #[error("layer {layer} has curves but no triangle with an area")]
    NoSurface {
        /// The layer, from 0.
        layer: usize,
    },
    /// What the part is built on cannot be used.
    #[error("the mould: {0}")]
    Mould(#[from] MouldError),
}

/// Why a mould cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MouldError {
    /// No triangle has an area.
    #[error("no triangle has an area")]
    NoArea,
    /// More triangles than can be numbered, those of the layers included.
    #[error("{triangles} triangles, those of the layers included, are too many: at most 2^30")]
    TooLarge {
        /// All triangles.
        triangles: usize,
    },
    /// A vertex has an invalid coordinate.
    #[error("vertex {vertex} is not finite or beyond 1e7 mm")]
    BadVertex {
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A triangle names a point that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// Vertices that there are.
        vertices: usize,
    },
    /// The thickness is not a length.
    #[error("a thickness of {thickness} mm: it must be above 0 and at most 1e7")]
    BadThickness {
        /// The thickness.
        thickness: f64,
    },
}
