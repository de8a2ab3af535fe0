//! The eight branches of the inverse, by name, in eight fixed slots: [`Branch`].

use crate::angle::apart;

/// Where the wrist lies as seen from axis 1. (On a UR arm "wrist" is where axes 5 and 6 cross.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shoulder {
    /// On the side to which the upper arm points when it lies level at zero, or leans forward.
    Front,
    /// On the other side: the arm reaches backwards over its shoulder.
    Back,
}

/// To which side the elbow is bent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Elbow {
    /// With the shoulder to the front: elbow above the line from shoulder to wrist. The sense of the elbow's turn
    /// counts, so the same sense is "up" with the shoulder to the back as well.
    Up,
    /// The other way.
    Down,
}

/// The sign of joint 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wrist {
    /// `sin q5 >= 0`, joint 5 counted from where axes 4 and 6 are parallel.
    NoFlip,
    /// `sin q5 < 0`.
    Flip,
}

/// One of the eight ways in which an arm reaches a pose.
///
/// Each of the three letters changes at one singularity and nowhere else, so a motion that meets no singularity stays on
/// its branch. The slot is `4 shoulder + 2 elbow + wrist` (0 or 1 each: back, down, flipped): for an ABB arm this is its
/// RAPID `cfx`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Branch {
    /// Front or back.
    pub shoulder: Shoulder,
    /// Up or down.
    pub elbow: Elbow,
    /// Flipped or not.
    pub wrist: Wrist,
}

impl Branch {
    /// All of them, in the order of their slots.
    pub const ALL: [Branch; 8] = {
        let mut all = [Branch { shoulder: Shoulder::Front, elbow: Elbow::Up, wrist: Wrist::NoFlip }; 8];
        let mut slot = 0;
        while slot < 8 {
            if slot & 4 != 0 {
                all[slot].shoulder = Shoulder::Back;
            }
            if slot & 2 != 0 {
                all[slot].elbow = Elbow::Down;
            }
            if slot & 1 != 0 {
                all[slot].wrist = Wrist::Flip;
            }
            slot += 1;
        }
        all
    };

    /// The branch's place among [`Branch::ALL`], 0 to 7.
    pub const fn slot(self) -> usize {
        4 * self.shoulder as usize + 2 * self.elbow as usize + self.wrist as usize
    }

    /// The branch with these signs: shoulder to the back, elbow down, wrist flipped.
    pub(super) fn of(back: bool, down: bool, flip: bool) -> Branch {
        Branch::ALL[slot(back, down, flip)]
    }
}

pub(super) fn slot(back: bool, down: bool, flip: bool) -> usize {
    4 * usize::from(back) + 2 * usize::from(down) + usize::from(flip)
}

/// Joints for each branch that reaches a pose. Lives on the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solutions {
    joints: [[f64; 6]; 8],
    present: u8,
}

/// Solutions that lie closer than this in every joint are one, in radians. Two branches come together at a stretched
/// elbow and where the shoulder folds; below this distance the pose does not distinguish them (the square of it
/// shows).
pub const SAME: f64 = 1e-6;

impl Default for Solutions {
    /// None.
    fn default() -> Self {
        Solutions::EMPTY
    }
}

impl Solutions {
    pub(super) const EMPTY: Solutions = Solutions { joints: [[0.0; 6]; 8], present: 0 };

    /// The joints of one branch, or `None` if it does not reach the pose.
    pub fn get(&self, branch: Branch) -> Option<&[f64; 6]> {
        self.at(branch.slot())
    }

    /// How many branches reach the pose.
    pub fn len(&self) -> usize {
        self.present.count_ones() as usize
    }

    /// Whether none does.
    pub fn is_empty(&self) -> bool {
        self.present == 0
    }

    /// The branches that reach the pose and their joints, in the order of the slots.
    pub fn iter(&self) -> impl Iterator<Item = (Branch, &[f64; 6])> {
        (0..8).filter(|&slot| self.has(slot)).map(|slot| (Branch::ALL[slot], &self.joints[slot]))
    }

    pub(super) fn at(&self, slot: usize) -> Option<&[f64; 6]> {
        self.has(slot).then(|| &self.joints[slot])
    }

    fn has(&self, slot: usize) -> bool {
        self.present >> slot & 1 != 0
    }

    pub(super) fn put(&mut self, slot: usize, joints: [f64; 6]) {
        self.joints[slot] = joints;
        self.present |= 1 << slot;
    }

    pub(super) fn remove(&mut self, branch: Branch) {
        self.present &= !(1 << branch.slot());
    }

    pub(super) fn map(&mut self, change: impl Fn(&mut [f64; 6])) {
        for slot in 0..8 {
            if self.has(slot) {
                change(&mut self.joints[slot]);
            }
        }
    }

    /// Of solutions that are one, keeps that in the first slot.
    pub(super) fn merge(&mut self) {
        for slot in 1..8 {
            let twin = |other: usize| {
                self.has(other) && (0..6).all(|k| apart(self.joints[slot][k], self.joints[other][k]) <= SAME)
            };
            if self.has(slot) && (0..slot).any(twin) {
                self.present &= !(1 << slot);
            }
        }
    }
}
