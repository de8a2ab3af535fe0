//! How a growth goes about it.

/// How to keep cells from being shadowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Prevention {
    /// Not at all: the greedy scheme (Dai's Algorithm 1).
    None,
    /// Candidates are tried one by one, in the order of their distance from a first one (Algorithm 2).
    #[default]
    Incremental,
    /// Candidates are tried all at once, and split in halves across their longest extent where they do harm
    /// (Algorithm 3).
    Adaptive,
    /// Candidates are tried one by one in their given order, and one is kept when it leaves fewer cells shadowed than all candidates
    /// would (Boge 2019, Algorithm 2 and section 6.1.2). Cells tested before count as built in that comparison.
    FewerThanAll,
    /// The same against a number, the voxel accumulation threshold of Boge's sections 6.1.2 and 6.2.5: a candidate is kept when it leaves fewer
    /// cells shadowed than this. With 1 none may be shadowed; with more than all candidates would shadow all are kept.
    FewerThan(u32),
}

/// Which cells become candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Candidates {
    /// Every neighbour of anything built.
    #[default]
    OfAllLayers,
    /// The neighbours of the last layer only, as printed: a cell held back may be out of reach afterwards.
    OfLastLayer,
}

/// In which order cells and their neighbours are looked at. It matters where candidates are tried in that order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Visit {
    /// By rising cell number: lowest level first.
    #[default]
    LowestFirst,
    /// Highest level first, and by rising cell number within a level.
    HighestFirst,
}

/// How [`grow`](super::grow()) goes about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct GrowthOptions {
    /// How to keep cells from being shadowed. Default: incremental.
    pub prevention: Prevention,
    /// Which cells become candidates. Default: the neighbours of all layers.
    pub candidates: Candidates,
    /// In which order cells are looked at. Default: lowest first.
    pub visit: Visit,
}
