//! Positions: written in `/POS`, read from it.

use super::options::{DEGREES, MM};
use crate::program::text::Text;
use crate::program::text::angles::{angles, rotation};
use crate::program::{ConfData, ExternalAxes, Target};
use nalgebra::{Isometry3, Translation3};

/// What a position is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Position {
    Pose(Target),
    Joints([f64; 6]),
}

/// The values of a table as those of motion group 2: `J1` on, without gaps. `None` where there is a gap.
fn group_two(table: ExternalAxes) -> Option<Vec<f64>> {
    let axes = table.axes();
    let count = axes.iter().take_while(|axis| axis.is_some()).count();
    let is_whole = axes[count..].iter().all(Option::is_none);
    is_whole.then(|| axes.iter().flatten().copied().collect())
}

/// External axes of a position.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct External {
    /// `E1` of motion group 1, in mm.
    pub track_mm: Option<f64>,
    /// `J1` and so on of motion group 2, in radians.
    pub table: Vec<f64>,
}

impl External {
    /// Of the external axes of a move; `None` for what has no words: gaps between the axes of a table, or other axes beside a track.
    pub fn of(axes: Option<ExternalAxes>, is_track: bool) -> Option<Self> {
        let Some(axes) = axes else { return Some(External::default()) };
        if is_track {
            return axes.track_mm().map(|mm| External { track_mm: Some(mm), table: Vec::new() });
        }
        group_two(axes).map(|table| External { track_mm: None, table })
    }
}

/// `P[1]{ .. };`
pub(super) fn write_position(
    text: &mut Text,
    number: u32,
    position: &Position,
    External { track_mm, table }: &External,
    [frame, tool]: [u8; 2],
) {
    let frames = |text: &mut Text| {
        text.word("\tUF : ").fixed(f64::from(frame), 0).word(", UT : ").fixed(f64::from(tool), 0).word(",\t");
    };
    text.word("P[").fixed(f64::from(number), 0).word("]{\n   GP1:\n");
    frames(text);
    match position {
        Position::Pose(target) => {
            write_config(text, target.conf);
            let at = target.pose.translation.vector;
            text.word("\tX = ").fixed(at.x, MM).word(" mm,\tY = ").fixed(at.y, MM).word(" mm,\tZ = ").fixed(at.z, MM);
            let [r, p, w] = angles(&target.pose.rotation).map(f64::to_degrees);
            text.word(" mm,\n\tW = ").fixed(w, DEGREES).word(" deg,\tP = ").fixed(p, DEGREES);
            text.word(" deg,\tR = ").fixed(r, DEGREES).word(" deg");
        }
        Position::Joints(joints) => {
            text.word("\n");
            write_joints(text, joints);
        }
    }
    if let Some(mm) = track_mm {
        text.word(",\n\tE1= ").fixed(*mm, MM).word(" mm");
    }
    text.word("\n");
    if !table.is_empty() {
        text.word("   GP2:\n");
        frames(text);
        text.word("\n");
        write_joints(text, table);
        text.word("\n");
    }
    text.word("};\n");
}

/// `J1= 0 deg,` and so on, three in a line.
fn write_joints(text: &mut Text, joints: &[f64]) {
    for (k, angle) in joints.iter().enumerate() {
        text.word("\tJ").fixed((k + 1) as f64, 0).word("= ").fixed(angle.to_degrees(), DEGREES).word(" deg");
        let is_last = k + 1 == joints.len();
        text.word(if is_last { "" } else { "," });
        if k % 3 == 2 && !is_last {
            text.word("\n");
        }
    }
}

/// `CONFIG : 'N U T, 0, 0, 0',`
fn write_config(text: &mut Text, conf: ConfData) {
    let bit = |bit: i32, letters: [&'static str; 2]| letters[usize::from(conf.cfx & bit != 0)];
    text.word("CONFIG : '").word(bit(1, ["N", "F"])).word(" ").word(bit(2, ["U", "D"])).word(" ");
    text.word(bit(4, ["T", "B"])).word(", ").fixed(f64::from(turn(conf.cf4)), 0).word(", 0, ");
    text.word(&turn(conf.cf6).to_string()).word("',\n");
}

/// Whole turns of a joint in this quarter turn: 0 within half a turn.
pub(super) fn turn(quarter: i32) -> i32 {
    (quarter + 2).div_euclid(4)
}

/// The configuration data of letters and turns: what they say, and 0 for the rest.
pub(super) fn conf([wrist, elbow, shoulder]: [char; 3], [turn4, turn6]: [i32; 2]) -> Option<ConfData> {
    let bit = |letter: char, letters: [char; 2]| letters.iter().position(|other| *other == letter);
    let bits = [bit(wrist, ['N', 'F'])?, bit(elbow, ['U', 'D'])?, bit(shoulder, ['T', 'B'])?];
    let cfx = bits.iter().enumerate().map(|(k, bit)| (*bit as i32) << k).sum();
    Some(ConfData { cf1: 0, cf4: turn4.checked_mul(4)?, cf6: turn6.checked_mul(4)?, cfx })
}

/// The pose of `X`, `Y`, `Z`, `W`, `P`, `R`, in mm and radians.
pub(super) fn pose([x, y, z, w, p, r]: [f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), rotation([r, p, w]))
}
