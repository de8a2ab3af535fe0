//! Setups: an arm, a part and a nozzle, and which of the two the arm holds. [`SetupFrames`] states frames and the zero of
//! the tool angle.

use crate::arm::{Arm, Branch, Rates};
use crate::pose::is_frame;
use crate::positioner::Positioner;
use crate::scene::Mount;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};

/// Where material is to be laid down, and in which direction it grows there, in the part frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// The place, in millimetres.
    pub position: Point3<f64>,
    /// The direction from the part towards the nozzle.
    pub axis: UnitVector3<f64>,
}

impl Waypoint {
    /// The deposition frame at a tool angle, `part_deposition`.
    /// ```
    /// use curvlay_kinematics::{Waypoint, nalgebra::{Point3, Vector3}};
    /// let up = Waypoint { position: Point3::new(1.0, 2.0, 3.0), axis: Vector3::z_axis() };
    /// let frame = up.frame(std::f64::consts::FRAC_PI_2);
    /// assert!((frame * Vector3::x() - Vector3::y()).norm() < 1e-15);
    /// ```
    pub fn frame(&self, tool_angle: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), tool_angle);
        Isometry3::from_parts(Translation3::from(self.position), onto(&self.axis) * turn)
    }
}

/// The shortest turn that takes z to `axis`.
fn onto(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    // 1 + cos is a difference below the horizon; there it is taken from the sine, which has all digits.
    let level = axis.x * axis.x + axis.y * axis.y;
    let risen = if axis.z >= 0.0 { 1.0 + axis.z } else { level / (1.0 - axis.z) };
    if risen <= 0.0 {
        return UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 0.0));
    }
    let scale = 1.0 / (risen * risen + level).sqrt();
    let quaternion = Quaternion::new(risen * scale, -axis.y * scale, axis.x * scale, 0.0);
    UnitQuaternion::new_normalize(quaternion)
}

/// The nozzle frame with this tip and this direction of flow.
/// ```
/// use curvlay_kinematics::{nalgebra::{Point3, Vector3}, nozzle_frame};
/// // A nozzle that hangs down: its frame stands upright.
/// let frame = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
/// assert_eq!(frame * Vector3::z(), Vector3::z());
/// ```
pub fn nozzle_frame(tip: &Point3<f64>, flow: &UnitVector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(*tip), onto(&-flow.into_inner()))
}

/// A frame that is no pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// An entry is not finite, or beyond 1e6 mm, or the quaternion has another length than 1.
    #[error("the frame `{frame}` is invalid: its entries must be finite and within 1e6 mm, its quaternion of length 1")]
    Frame {
        /// Its name.
        frame: &'static str,
    },
}

fn sound(frame: &'static str, pose: &Isometry3<f64>) -> Result<(), SetupError> {
    if is_frame(pose) { Ok(()) } else { Err(SetupError::Frame { frame }) }
}

/// What the arm holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Part,
    Nozzle,
}

/// The frames of a setup, all in the base, which is the world: those of C. Dai, *Material Deposition in 3D Space*
/// (dissertation, TU Delft 2020), section 2.5, Fig. 2.7.
///
/// Symbols of Eq. 2.3, `T_E^B T_P^E T_O^P = T_N^B`, and section 4.3.1 (the free turn about the tool axis, Eq. 4.3):
/// `T_E^B` is `base_flange` in this crate, `T_P^E` is `flange_part`, `T_O^P` comes from a [`Waypoint`] and the tool angle,
/// `T_N^B` is `base_nozzle`.
///
/// The nozzle frame N has its origin at the tip; its z axis runs from the tip up into the nozzle, against the flow, so that
/// it coincides with the deposition frame O, whose z axis is the direction in which material grows. The tool angle turns
/// O about z, in radians. At angle 0, O is the part frame turned by the shortest way that takes z to the waypoint's axis
/// (about x where the axis is -z).
///
/// Departs from the dissertation: the nozzle may be in the hand and the part on its stand as well, and the stand may be the
/// table of a [`Positioner`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetupFrames {
    /// B: the base of the arm, which is the world.
    pub base: Isometry3<f64>,
    /// E: the end-effector, which is the flange.
    pub end_effector: Isometry3<f64>,
    /// P: the part.
    pub part: Isometry3<f64>,
    /// O: where material is laid down. At a configuration of the waypoint it coincides with N.
    pub deposition: Isometry3<f64>,
    /// N: the nozzle.
    pub nozzle: Isometry3<f64>,
}

/// One way in which an arm reaches a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// Which of the sampled tool angles.
    pub sample: usize,
    /// That angle, in `[-pi, pi)`.
    pub tool_angle: f64,
    /// Which of the arm's branches.
    pub branch: Branch,
    /// The arm's joints, within their limits.
    pub joints: [f64; 6],
}

/// An arm that holds the part under a nozzle, or the nozzle over a part; what it does not hold stands still.
///
/// ```
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
/// use curvlay_kinematics::{Arm, Setup, Waypoint, nozzle_frame, robots};
/// // A UR3 holds the part under a nozzle that hangs down.
/// let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
/// let setup = Setup::part_in_hand(Arm::new(&robots::UR3)?, Isometry3::translation(0.0, 0.0, 45.0), nozzle)?;
/// let waypoint = Waypoint { position: Point3::new(10.0, -5.0, 20.0), axis: Vector3::z_axis() };
/// let all: Vec<_> = setup.configurations(&waypoint, 30).collect();
/// assert!(all.len() > 100);
/// for found in &all {
///     let frames = setup.frames(&found.joints, &waypoint, found.tool_angle);
///     assert!((frames.deposition.translation.vector - frames.nozzle.translation.vector).norm() < 1e-6);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    arm: Arm,
    held: Held,
    /// What the arm holds, on its flange.
    flange_held: Isometry3<f64>,
    /// What it does not hold, in the base.
    base_other: Isometry3<f64>,
}

impl Setup {
    /// The arm holds the part; the nozzle stands still.
    ///
    /// # Errors
    /// [`SetupError`] names the frame that is no pose.
    pub fn part_in_hand(
        arm: Arm,
        flange_part: Isometry3<f64>,
        base_nozzle: Isometry3<f64>,
    ) -> Result<Self, SetupError> {
        sound("flange_part", &flange_part)?;
        sound("base_nozzle", &base_nozzle)?;
        Ok(Setup { arm, held: Held::Part, flange_held: flange_part, base_other: base_nozzle })
    }

    /// The arm holds the nozzle; the part stands still.
    ///
    /// # Errors
    /// [`SetupError`] names the frame that is no pose.
    pub fn nozzle_in_hand(
        arm: Arm,
        flange_nozzle: Isometry3<f64>,
        base_part: Isometry3<f64>,
    ) -> Result<Self, SetupError> {
        sound("flange_nozzle", &flange_nozzle)?;
        sound("base_part", &base_part)?;
        Ok(Setup { arm, held: Held::Nozzle, flange_held: flange_nozzle, base_other: base_part })
    }

    /// The same setup with the base of the arm elsewhere: what the arm does not hold stays where it is, and is given in the frame of the base from now on.
    ///
    /// # Arguments
    /// * `shift`: how far the base has gone, in millimetres, in the frame that it had.
    pub fn with_base_at(&self, shift: &Vector3<f64>) -> Self {
        Setup { base_other: Translation3::from(-shift) * self.base_other, ..*self }
    }

    /// The arm.
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// What the part is fixed to, flange or base, and its frame there.
    /// ```
    /// use curvlay_kinematics::{Arm, Setup, nalgebra::Isometry3, robots, scene::Mount};
    /// let (part, nozzle) = (Isometry3::translation(0.0, 0.0, 45.0), Isometry3::translation(300.0, 60.0, 220.0));
    /// let setup = Setup::part_in_hand(Arm::new(&robots::UR3)?, part, nozzle)?;
    /// assert_eq!(setup.part_frame(), (Mount::Link(6), part));
    /// assert_eq!(setup.nozzle_frame(), (Mount::Base, nozzle));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn part_frame(&self) -> (Mount, Isometry3<f64>) {
        match self.held {
            Held::Part => (Mount::Link(6), self.flange_held),
            Held::Nozzle => (Mount::Base, self.base_other),
        }
    }

    /// What the nozzle is fixed to, base or flange, and its frame there.
    pub fn nozzle_frame(&self) -> (Mount, Isometry3<f64>) {
        match self.held {
            Held::Part => (Mount::Base, self.base_other),
            Held::Nozzle => (Mount::Link(6), self.flange_held),
        }
    }

    /// Where the flange must be for a waypoint at a tool angle, `base_flange`: Eq. 2.3 solved for it.
    pub fn flange(&self, waypoint: &Waypoint, tool_angle: f64) -> Isometry3<f64> {
        let part_deposition = waypoint.frame(tool_angle);
        match self.held {
            Held::Part => self.base_other * (self.flange_held * part_deposition).inverse(),
            Held::Nozzle => self.base_other * part_deposition * self.flange_held.inverse(),
        }
    }

    /// The frames of the setup, for the arm at `joints` and the deposition frame of a waypoint.
    pub fn frames(&self, joints: &[f64; 6], waypoint: &Waypoint, tool_angle: f64) -> SetupFrames {
        let end_effector = self.arm.forward(joints);
        let held = end_effector * self.flange_held;
        let (part, nozzle) = match self.held {
            Held::Part => (held, self.base_other),
            Held::Nozzle => (self.base_other, held),
        };
        let deposition = part * waypoint.frame(tool_angle);
        SetupFrames { base: Isometry3::identity(), end_effector, part, deposition, nozzle }
    }

    /// Where the nozzle is on the part, `part_nozzle`: the forward kinematics of the setup.
    pub fn nozzle_on_part(&self, joints: &[f64; 6]) -> Isometry3<f64> {
        let held = self.arm.forward(joints) * self.flange_held;
        match self.held {
            Held::Part => held.inverse() * self.base_other,
            Held::Nozzle => self.base_other.inverse() * held,
        }
    }

    /// Every configuration that reaches the waypoint at one of `samples` tool angles `-pi + 2 pi k / samples`, in the
    /// order of the angles and then of the branches' slots.
    ///
    /// Each branch with an image within the limits comes once, with the image nearest to the middle of the limits (to
    /// zero where a joint turns without end); [`JointLimits::images`](crate::JointLimits::images) gives the others. A
    /// waypoint that is not finite has none.
    ///
    /// # Cost
    /// About two microseconds an angle, no allocation; the angles are computed as they are asked for.
    pub fn configurations(&self, waypoint: &Waypoint, samples: usize) -> impl Iterator<Item = Configuration> {
        let limits = *self.arm.limits();
        let middle = std::array::from_fn(|k| {
            let middle = 0.5 * (limits.lower[k] + limits.upper[k]);
            if middle.is_finite() { middle } else { 0.0 }
        });
        let (setup, waypoint) = (*self, *waypoint);
        (0..samples).flat_map(move |sample| {
            let tool_angle = TAU * (sample as f64 / samples as f64) - PI;
            // An invalid waypoint has no solutions.
            let found = setup.arm.inverse(&setup.flange(&waypoint, tool_angle)).unwrap_or_default();
            Branch::ALL.into_iter().filter_map(move |branch| {
                let joints = limits.nearest_image(found.get(branch)?, &middle)?;
                Some(Configuration { sample, tool_angle, branch, joints })
            })
        })
    }

    /// How the joints change with the tool angle while the waypoint stays: first and second derivatives on the branch
    /// of `joints`. `None` at a singularity.
    pub fn tool_rates(&self, joints: &[f64; 6]) -> Option<Rates> {
        let (nozzle, sense) = match self.held {
            // The part turns under the nozzle, so it turns the other way.
            Held::Part => (self.base_other, -1.0),
            Held::Nozzle => (self.arm.forward(joints) * self.flange_held, 1.0),
        };
        let axis = UnitVector3::new_unchecked(nozzle.rotation * Vector3::z() * sense);
        self.arm.rates_about(joints, &Point3::from(nozzle.translation.vector), &axis)
    }
}

/// A setup in which the table of a positioner carries what the arm does not hold: eight axes.
///
/// With the table at given joints it is a [`Setup`].
/// ```
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
/// use curvlay_kinematics::{Arm, Positioner, TableSetup, Waypoint, nozzle_frame, robots};
/// // The tilt axis passes 120 mm above the floor, 520 mm in front of an IRB 1200.
/// let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::translation(520.0, 0.0, -900.0))?;
/// let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 150.0), &Vector3::z_axis());
/// let setup = TableSetup::nozzle_in_hand(Arm::new(&robots::IRB1200)?, nozzle, positioner, Isometry3::identity())?;
/// let leaning = UnitVector3::new_normalize(Vector3::new(0.3, 0.2, 1.0));
/// let waypoint = Waypoint { position: Point3::new(5.0, 0.0, 30.0), axis: leaning };
/// // Turned so that the layer is level, and the nozzle hangs down.
/// let [table, _] = setup.aligning(&waypoint, &Vector3::z(), &[0.0; 2]);
/// let at = setup.at(&table.ok_or("out of reach")?).ok_or("beyond its limits")?;
/// assert!(at.configurations(&waypoint, 8).count() > 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableSetup {
    /// The setup with its other thing as it stands on the table instead of in the base.
    setup: Setup,
    positioner: Positioner,
}

impl TableSetup {
    /// The arm holds the part; the table carries the nozzle.
    ///
    /// # Errors
    /// [`SetupError`] names the frame that is no pose.
    pub fn part_in_hand(
        arm: Arm,
        flange_part: Isometry3<f64>,
        positioner: Positioner,
        table_nozzle: Isometry3<f64>,
    ) -> Result<Self, SetupError> {
        sound("table_nozzle", &table_nozzle)?;
        Ok(TableSetup { setup: Setup::part_in_hand(arm, flange_part, table_nozzle)?, positioner })
    }

    /// The arm holds the nozzle; the table carries the part.
    ///
    /// # Errors
    /// [`SetupError`] names the frame that is no pose.
    pub fn nozzle_in_hand(
        arm: Arm,
        flange_nozzle: Isometry3<f64>,
        positioner: Positioner,
        table_part: Isometry3<f64>,
    ) -> Result<Self, SetupError> {
        sound("table_part", &table_part)?;
        Ok(TableSetup { setup: Setup::nozzle_in_hand(arm, flange_nozzle, table_part)?, positioner })
    }

    /// The positioner.
    pub fn positioner(&self) -> &Positioner {
        &self.positioner
    }

    /// The arm.
    pub fn arm(&self) -> &Arm {
        self.setup.arm()
    }

    /// What the part is fixed to, flange or table, and its frame there.
    pub fn part_frame(&self) -> (Mount, Isometry3<f64>) {
        on_table(self.setup.part_frame())
    }

    /// What the nozzle is fixed to, table or flange, and its frame there.
    pub fn nozzle_frame(&self) -> (Mount, Isometry3<f64>) {
        on_table(self.setup.nozzle_frame())
    }

    /// The setup with the table at these joints; `None` beyond its limits.
    pub fn at(&self, table: &[f64; 2]) -> Option<Setup> {
        let base_other = self.positioner.forward(table) * self.setup.base_other;
        self.positioner.limits().contains(table).then_some(Setup { base_other, ..self.setup })
    }

    /// Joints of the table at which the direction of growth points in this direction of the base: the axis of the
    /// waypoint where the table carries the part, else the axis of the nozzle. As [`Positioner::aligning`].
    pub fn aligning(
        &self,
        waypoint: &Waypoint,
        base_direction: &Vector3<f64>,
        reference: &[f64; 2],
    ) -> [Option<[f64; 2]>; 2] {
        let growth = match self.setup.held {
            Held::Part => Vector3::z(),
            Held::Nozzle => waypoint.axis.into_inner(),
        };
        self.positioner.aligning(&(self.setup.base_other.rotation * growth), base_direction, reference)
    }

    /// How the arm's joints follow the tool angle, the tilt and the turn, each alone, while the waypoint stays: first
    /// and second derivatives. `None` at a singularity, or with the table beyond its limits.
    pub fn rates(&self, table: &[f64; 2], joints: &[f64; 6]) -> Option<[Rates; 3]> {
        let [tilt, turn] = self.positioner.axes(table);
        let follow = |(point, axis): (Point3<f64>, UnitVector3<f64>)| self.setup.arm.rates_about(joints, &point, &axis);
        Some([self.at(table)?.tool_rates(joints)?, follow(tilt)?, follow(turn)?])
    }
}

/// What the arm does not hold is on the table, not in the base.
fn on_table((mount, frame): (Mount, Isometry3<f64>)) -> (Mount, Isometry3<f64>) {
    (if mount == Mount::Base { Mount::Table } else { mount }, frame)
}
