//! Why a URDF gives no arm.

/// How two axes are to each other where a family wants them otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Misfit {
    /// They should be parallel, and are so many radians off it.
    NotParallel(f64),
    /// They should be at right angles, and are so many radians off it.
    NotSquare(f64),
    /// They should meet, and are so many millimetres apart.
    Apart(f64),
    /// They should be apart, and are the same line: the link between them has no length.
    Same,
}

/// The axis that is not where a family has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMisfit {
    /// The axis, counted from 0.
    pub axis: usize,
    /// The one that it is compared with.
    pub against: usize,
    /// What is wrong.
    pub misfit: Misfit,
}

impl std::fmt::Display for AxisMisfit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (axis, against) = (self.axis + 1, self.against + 1);
        match self.misfit {
            Misfit::NotParallel(angle) => {
                write!(f, "axis {axis} is {:.4} degrees off parallel to axis {against}", angle.to_degrees())
            }
            Misfit::NotSquare(angle) => {
                write!(f, "axis {axis} is {:.4} degrees off the right angle to axis {against}", angle.to_degrees())
            }
            Misfit::Apart(mm) => write!(f, "axis {axis} passes axis {against} at {mm:.3} mm instead of meeting it"),
            Misfit::Same => write!(f, "axis {axis} is the same line as axis {against}"),
        }
    }
}

/// Why a URDF gives no arm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The text is no XML.
    #[error("line {line}, column {column}: not XML: {what}")]
    Xml {
        /// The line, counted from 1.
        line: u32,
        /// The column, counted from 1.
        column: u32,
        /// What is wrong there.
        what: String,
    },
    /// The XML is no URDF.
    #[error("the outermost element is <{found}>, a URDF has <robot>")]
    NotRobot {
        /// Its name.
        found: String,
    },
    /// Macros have not been expanded.
    #[error("line {line}: this is a xacro file; expand it first: xacro FILE > arm.urdf")]
    Xacro {
        /// The line of the first macro.
        line: u32,
    },
    /// An element lacks what it needs, or a value is not what it must be.
    #[error("line {line}: {what}")]
    Element {
        /// The line, counted from 1.
        line: u32,
        /// What is wrong there.
        what: String,
    },
    /// No joint at all.
    #[error("no joint is in the file: an arm has six that turn")]
    NoJoints,
    /// A link hangs on two joints.
    #[error("link `{link}` is the child of joints `{first}` and `{second}`: a closed chain has no closed form here")]
    ClosedChain {
        /// The link.
        link: String,
        /// A joint.
        first: String,
        /// Another one.
        second: String,
    },
    /// Links hang on each other in a circle.
    #[error("link `{link}` hangs on itself: the joints are a closed chain")]
    Circle {
        /// One of the links.
        link: String,
    },
    /// Several links hang on nothing.
    #[error("links `{first}` and `{second}` are both the child of no joint: one of them is not joined to the arm")]
    TwoRoots {
        /// A link.
        first: String,
        /// Another one.
        second: String,
    },
    /// No such link.
    #[error("no link is called `{link}`")]
    NoLink {
        /// The name.
        link: String,
    },
    /// The base turns.
    #[error("link `{link}` cannot be the base: joint `{joint}` moves it")]
    BaseMoves {
        /// The link.
        link: String,
        /// The joint.
        joint: String,
    },
    /// Not six turning joints between base and flange.
    #[error("from `{base}` to `{flange}` {found} joints turn: an arm has six{hint}")]
    NotSix {
        /// The base.
        base: String,
        /// The flange.
        flange: String,
        /// How many joints turn.
        found: usize,
        /// What to do.
        hint: &'static str,
    },
    /// Several chains of six joints.
    #[error("several chains have six turning joints, one to `{first}` and one to `{second}`: name the flange")]
    SeveralArms {
        /// A link.
        first: String,
        /// Another one.
        second: String,
    },
    /// A joint of the chain is none that an arm has.
    #[error("joint `{joint}` is {kind}: between base and flange only turning joints (revolute, continuous) are taken")]
    OtherJoint {
        /// The joint.
        joint: String,
        /// Its type.
        kind: String,
    },
    /// A joint follows another one.
    #[error(
        "joint `{joint}` mimics joint `{of}`: coupled joints are not taken from a URDF; give the arm by lengths with `j23_factor`"
    )]
    Mimic {
        /// The joint.
        joint: String,
        /// The one that it follows.
        of: String,
    },
    /// The axes are those of neither family.
    #[error("joint `{joint}`: {misfit}; the arm is nearest to {family}, which needs that")]
    NeitherFamily {
        /// The joint of the axis.
        joint: String,
        /// How its axis is.
        misfit: AxisMisfit,
        /// The family that is nearest.
        family: &'static str,
    },
    /// The axes fit, and yet the numbers make no arm, or one that is elsewhere.
    #[error("{what}")]
    Numbers {
        /// What is wrong with them.
        what: String,
    },
}
