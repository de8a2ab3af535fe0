//! How a file in the frame of the part says the direction of the nozzle.

/// How the direction of the nozzle is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectionWords {
    /// In a comment behind the words: `G1 X.. Y.. Z.. E.. ;DIR:0 0.6 0.8`. Firmware that knows no directions prints upright.
    #[default]
    Comment,
    /// As `I J K`. Controllers that take these for arcs alone refuse such lines (LinuxCNC, grbl).
    Ijk,
    /// As `nX nY nZ`, the words of Dai 2020, appendix. Only for machines that are known to read them: firmware that takes words
    /// of one letter may read the `X` behind the `n` and drive there.
    Dissertation,
}

/// What a direction in a comment begins with.
pub(super) const COMMENT: &str = ";DIR:";

impl DirectionWords {
    /// What the first line of a file calls it.
    pub(super) fn title(self) -> &'static str {
        match self {
            DirectionWords::Comment => "direction in comments",
            DirectionWords::Ijk => "direction as I J K",
            DirectionWords::Dissertation => "direction as nX nY nZ",
        }
    }

    /// What each number stands behind.
    pub(super) fn names(self) -> [&'static str; 3] {
        match self {
            DirectionWords::Comment => ["DIR", "DIR", "DIR"],
            DirectionWords::Ijk => ["I", "J", "K"],
            DirectionWords::Dissertation => ["nX", "nY", "nZ"],
        }
    }
}
