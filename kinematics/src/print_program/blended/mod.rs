//! A print as few moves with blends, for controllers that interpolate by themselves: `movep` and `movej` of URScript.
//!
//! A planned motion is a timed curve of joints. [`print_blended`] chooses some of its samples as the ends of moves, each as far from the one before as
//! the tolerances of [`BlendOptions`] allow, and rounds the corners between them as wide as the tolerances allow. While it prints, the tool goes in lines; all
//! else goes by joints.
//!
//! *Path.* A controller of Universal Robots moves the TCP of a `movel` or `movep` in a straight line and turns it about one axis, both in step (*Script
//! Manual*, module motion). With the part in the hand the TCP is a point of the part, so the tip goes along a curve on the part: what is compared is that curve. Half of
//! a tolerance is for lines, half for corners. A corner counts as the parabola from where its blend begins to where it ends.
//!
//! *Time.* Each move takes the time that the plan takes between its ends. A move that begins or ends at rest is faster in between, as it has to speed up and
//! slow down. The speed of the filament is that which lays the plan's bead at the speed of the move.

mod cruise;
mod lag;
mod lines;
mod options;
mod span;
mod steps;
mod ways;

pub use options::{BlendOptions, BlendedSegment};
pub use steps::print_blended;
