//! Why there are no figures.

/// Why there are no figures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatisticsError {
    /// There is no triangle, or none has an area.
    #[error("the surface has no area")]
    NoArea,
    /// Triangles are counted in 32 bits.
    #[error("{triangles} triangles over {vertices} vertices are too many: at most 2^29 each")]
    TooLarge {
        /// Triangles given.
        triangles: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A coordinate is NaN, infinite or absurd.
    #[error("vertex {vertex} has a coordinate that is not finite or beyond 1e100")]
    BadVertex {
        /// Number of the vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Vertices given.
        vertices: usize,
    },
    /// A triangle has a vertex twice.
    #[error("triangle {triangle} repeats a corner")]
    RepeatedCorner {
        /// Number of the triangle.
        triangle: usize,
    },
    /// More than two triangles meet in an edge, so it is not clear where a bead goes on.
    #[error("triangle {triangle} is one of more than two at the edge between vertices {from} and {to}")]
    NonManifoldEdge {
        /// One of the triangles.
        triangle: usize,
        /// One end of the edge.
        from: u32,
        /// The other end.
        to: u32,
    },
    /// A curve has more or fewer widths than points.
    #[error("curve {curve} has {points} points and {widths} widths; give one for each point")]
    WidthCount {
        /// Number of the curve.
        curve: usize,
        /// Its points.
        points: usize,
        /// Its widths.
        widths: usize,
    },
    /// A coordinate of a curve is NaN, infinite or absurd.
    #[error("point {point} of curve {curve} has a coordinate that is not finite or beyond 1e100")]
    BadPoint {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
    },
    /// A width is not a length.
    #[error("curve {curve} is {width} mm wide at point {point}; it must be above zero, at most 1e100")]
    BadWidth {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
        /// The width.
        width: f64,
    },
    /// A point of a curve does not lie on the surface.
    #[error("point {point} of curve {curve} is farther than half its width, {reach} mm, from the surface")]
    OffSurface {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
        /// Half the width there, in millimetres.
        reach: f64,
    },
    /// The raster would need too many samples.
    #[error("a step of {step} mm takes about {samples} samples, above the limit of {most}: are the units right?")]
    TooFine {
        /// Step of the raster, in millimetres.
        step: f64,
        /// Samples it would take, about.
        samples: f64,
        /// The limit.
        most: usize,
    },
    /// An option makes no sense.
    #[error("option {option} is {value}: it must be {wanted}")]
    BadOption {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}
