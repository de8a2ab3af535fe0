//! Signals of a tape head: digital outputs with a name each.
//!
//! C. Dai (dissertation, TU Delft 2020), section 5.3.1: fibre is fed, heated, pressed and cut. A robot program switches what the head's own controller
//! does: how hot and with which force is set up there. The words of a machine file (`M2730` to `M2735` of `curvlay-toolpath`) become these:
//!
//! | machine file | on | off |
//! |---|---|---|
//! | tool: roller, conductor | [`HeadSignal::Roller`], [`HeadSignal::Conductor`] | the nozzle works |
//! | heat | [`HeadSignal::Heat`] | |
//! | feed | [`HeadSignal::Feed`]: tape is pushed out under the roller | |
//! | press | [`HeadSignal::Press`] | |
//! | cut | [`HeadSignal::Cut`]: the blade comes down | it goes back |
//!
//! What takes time is waited for ([`Step::Wait`](super::Step::Wait)): the head says by an input that its tool is in place, that the roller has its
//! temperature, and that tape is pushed out ([`HeadInput`]).
//!
//! RAPID has the name as the signal (`SetDO doTapeCut,1;`). URScript numbers its outputs, so the name is a variable that is set before its first use
//! (`tape_cut=6`): another wiring is one line. CSV has it as the kind of its line.

/// A digital output of a tape head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadSignal {
    /// The roller is in place of the nozzle.
    Roller,
    /// The roller for conducting fibre is in place of the nozzle.
    Conductor,
    /// The roller is heated.
    Heat,
    /// Tape is pushed out.
    Feed,
    /// The roller presses.
    Press,
    /// The blade is down.
    Cut,
}

impl HeadSignal {
    /// All of them, by their number.
    pub const ALL: [HeadSignal; 6] = [
        HeadSignal::Roller,
        HeadSignal::Conductor,
        HeadSignal::Heat,
        HeadSignal::Feed,
        HeadSignal::Press,
        HeadSignal::Cut,
    ];

    /// Its number in [`HeadSignal::ALL`].
    pub(crate) fn number(self) -> usize {
        self as usize
    }

    /// The signal of a RAPID program.
    ///
    /// ```
    /// use curvlay_kinematics::program::HeadSignal;
    /// assert_eq!(HeadSignal::ALL.map(HeadSignal::rapid), ["doRoller", "doConductor", "doTapeHeat", "doTapeFeed", "doTapePress", "doTapeCut"]);
    /// ```
    pub fn rapid(self) -> &'static str {
        ["doRoller", "doConductor", "doTapeHeat", "doTapeFeed", "doTapePress", "doTapeCut"][self.number()]
    }

    /// The variable of a URScript program that holds its output.
    ///
    /// ```
    /// use curvlay_kinematics::program::HeadSignal;
    /// assert_eq!(HeadSignal::Cut.urscript(), "tape_cut");
    /// ```
    pub fn urscript(self) -> &'static str {
        ["roller", "conductor", "tape_heat", "tape_feed", "tape_press", "tape_cut"][self.number()]
    }

    /// Outputs of a UR controller unless others are chosen: 1 to 6, as the extruder has 0.
    pub const UR_OUTPUTS: [u8; 6] = [1, 2, 3, 4, 5, 6];
}

/// A digital input that a tape head sets, for which a program waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadInput {
    /// The tool that was called, roller or nozzle, is in place and locked.
    ToolReady,
    /// The roller has the temperature that was set.
    Hot,
    /// The tape reaches from the blade to the roller.
    Fed,
}

impl HeadInput {
    /// All of them, by their number.
    pub const ALL: [HeadInput; 3] = [HeadInput::ToolReady, HeadInput::Hot, HeadInput::Fed];

    /// Its number in [`HeadInput::ALL`].
    pub(crate) fn number(self) -> usize {
        self as usize
    }

    /// The signal of a RAPID program.
    ///
    /// ```
    /// use curvlay_kinematics::program::HeadInput;
    /// assert_eq!(HeadInput::ALL.map(HeadInput::rapid), ["diToolReady", "diTapeHot", "diTapeFed"]);
    /// ```
    pub fn rapid(self) -> &'static str {
        ["diToolReady", "diTapeHot", "diTapeFed"][self.number()]
    }

    /// The variable of a URScript program that holds its input.
    ///
    /// ```
    /// use curvlay_kinematics::program::HeadInput;
    /// assert_eq!(HeadInput::Hot.urscript(), "tape_hot");
    /// ```
    pub fn urscript(self) -> &'static str {
        ["tool_ready", "tape_hot", "tape_fed"][self.number()]
    }

    /// Inputs of a UR controller unless others are chosen.
    pub const UR_INPUTS: [u8; 3] = [1, 2, 3];
}

/// A signal at a time of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedSignal {
    /// Seconds since the motion began.
    pub time_s: f64,
    /// Which.
    pub signal: HeadSignal,
    /// On or off.
    pub on: bool,
}
