//! Measurements for a calibration, from JSON and CSV: postures with touches of one point, and postures with measured poses.
//!
//! [`Measurements`] describes both formats. Angles are in degrees there, as on pendants.

use super::data::MeasuredPose;
use crate::arm::Arm;
use crate::pose::MAX_COORDINATE;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use std::io::{BufRead, BufReader, Read, Write};

/// A posture in which the tip touches the mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touch {
    /// By the joints of the arm, in radians.
    Joints([f64; 6]),
    /// By the flange, as the controller shows it.
    Flange(Isometry3<f64>),
}

impl Touch {
    /// Where the flange is.
    pub fn base_flange(&self, arm: &Arm) -> Isometry3<f64> {
        match self {
            Touch::Joints(joints) => arm.forward(joints),
            Touch::Flange(pose) => *pose,
        }
    }
}

/// What was measured.
///
#[doc = include_str!("../../docs/measurements.md")]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// Touches of one point by the tip.
    pub touches: Vec<Touch>,
    /// Poses of a target on the flange, by a device beside the arm.
    pub poses: Vec<MeasuredPose>,
}

/// Why a file holds no measurements.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasurementError {
    /// It cannot be read or written.
    #[error("{what}")]
    Io {
        /// What the system says.
        what: String,
    },
    /// It is not JSON, a field is missing, unknown or of another kind.
    #[error("line {line}, column {column}: {what}")]
    Json {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What is wrong there.
        what: String,
    },
    /// A line of a table is wrong.
    #[error("line {line}: {what}")]
    Csv {
        /// From 1.
        line: usize,
        /// What is wrong there.
        what: String,
    },
    /// A version of the format that this crate does not know.
    #[error("version: {found} is not known, only 1 is")]
    Version {
        /// What the file says.
        found: u32,
    },
    /// A number cannot be what it is.
    #[error("{path} is {value}: it must be from -1e6 to 1e6")]
    Number {
        /// The field, as `poses[3].joints_deg[0]`.
        path: String,
        /// Its value.
        value: f64,
    },
    /// A touch has neither joints nor a flange, or both.
    #[error("touches[{index}]: give `joints_deg`, or `flange` as the controller shows it, one of the two")]
    Touch {
        /// Its place.
        index: usize,
    },
}

/// Columns of a table, in any order; those of `kind` and of what the rows use must be there.
const COLUMNS: [&str; 13] = [
    "kind",
    "joint1_deg",
    "joint2_deg",
    "joint3_deg",
    "joint4_deg",
    "joint5_deg",
    "joint6_deg",
    "x_mm",
    "y_mm",
    "z_mm",
    "roll_deg",
    "pitch_deg",
    "yaw_deg",
];

/// Lines of a table at most, and bytes of a line: far more than anybody measures.
const MAX_LINES: usize = 1_000_000;
const MAX_LINE_BYTES: u64 = 10_000;

impl Measurements {
    /// Reads a table: a header with the names of the columns, then a line for each posture. `kind` is `touch` or `pose`.
    ///
    /// # Errors
    /// [`MeasurementError`] names line and column.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::{Measurements, Touch};
    /// let table = "kind,joint1_deg,joint2_deg,joint3_deg,joint4_deg,joint5_deg,joint6_deg,x_mm,y_mm,z_mm\n\
    ///              touch,0,-90,90,0,90,0,,,\n\
    ///              pose,10,-80,70,5,60,20,812.3,-40.1,655.0\n";
    /// let measured = Measurements::from_csv(table.as_bytes())?;
    /// assert_eq!((measured.touches.len(), measured.poses.len()), (1, 1));
    /// assert!(matches!(measured.touches[0], Touch::Joints([0.0, ..])));
    /// # Ok::<(), curvlay_kinematics::MeasurementError>(())
    /// ```
    pub fn from_csv(input: impl Read) -> Result<Self, MeasurementError> {
        let mut reader = BufReader::new(input);
        let mut places: Option<[Option<usize>; COLUMNS.len()]> = None;
        let mut found = Measurements::default();
        for line in 1..=MAX_LINES {
            let mut bytes = vec![];
            let io = |error: std::io::Error| MeasurementError::Io { what: error.to_string() };
            let read = reader.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut bytes).map_err(io)?;
            let bad = |what: String| MeasurementError::Csv { line, what };
            if read == 0 {
                break;
            }
            if read as u64 == MAX_LINE_BYTES {
                return Err(bad(format!("longer than {MAX_LINE_BYTES} bytes: this is no table of measurements")));
            }
            let text = String::from_utf8(bytes).map_err(|_| bad("not UTF-8 text".into()))?;
            let text = text.trim_start_matches('\u{feff}').trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            match &places {
                None => places = Some(header(&cells).map_err(bad)?),
                Some(places) => row(&cells, places, &mut found).map_err(bad)?,
            }
        }
        if places.is_none() {
            return Err(MeasurementError::Csv {
                line: 1,
                what: format!("no header; it begins with `{}`", COLUMNS[..2].join(",")),
            });
        }
        Ok(found)
    }

    /// Writes a table that [`Measurements::from_csv`] reads.
    ///
    /// # Errors
    /// [`MeasurementError::Io`].
    pub fn write_csv(&self, mut output: impl Write) -> Result<(), MeasurementError> {
        let mut text = COLUMNS.join(",") + "\n";
        let joints = |joints: &[f64; 6]| joints.map(|angle| angle.to_degrees().to_string()).join(",");
        let place = |p: &Point3<f64>| format!("{},{},{}", p.x, p.y, p.z);
        let turn = |rotation: &UnitQuaternion<f64>| {
            let (roll, pitch, yaw) = rotation.euler_angles();
            [roll, pitch, yaw].map(|angle| angle.to_degrees().to_string()).join(",")
        };
        for touch in &self.touches {
            text += &match touch {
                Touch::Joints(q) => format!("touch,{},,,,,,\n", joints(q)),
                Touch::Flange(pose) => {
                    format!("touch,,,,,,,{},{}\n", place(&pose.translation.vector.into()), turn(&pose.rotation))
                }
            };
        }
        for pose in &self.poses {
            let turn = pose.rotation.as_ref().map_or_else(|| ",,".into(), turn);
            text += &format!("pose,{},{},{turn}\n", joints(&pose.joints), place(&pose.position));
        }
        let io = |error: std::io::Error| MeasurementError::Io { what: error.to_string() };
        output.write_all(text.as_bytes()).map_err(io)
    }
}

/// Where each column stands.
fn header(cells: &[&str]) -> Result<[Option<usize>; COLUMNS.len()], String> {
    if let Some(unknown) = cells.iter().find(|cell| !COLUMNS.contains(cell)) {
        return Err(format!("`{unknown}` is no column; known are {}", COLUMNS.join(", ")));
    }
    if let Some(twice) = cells.iter().enumerate().find(|(k, cell)| cells[..*k].contains(cell)) {
        return Err(format!("the column `{}` is there twice", twice.1));
    }
    let places = COLUMNS.map(|name| cells.iter().position(|cell| *cell == name));
    if places[0].is_none() { Err("no column `kind`, which says `touch` or `pose`".into()) } else { Ok(places) }
}

fn row(cells: &[&str], places: &[Option<usize>; COLUMNS.len()], found: &mut Measurements) -> Result<(), String> {
    let columns = places.iter().flatten().count();
    if cells.len() != columns {
        return Err(format!("{} cells, the header has {columns}", cells.len()));
    }
    let cell = |column: usize| places[column].map_or("", |place| cells[place]);
    let joints = numbers::<6>(1, &cell)?.map(|degrees| degrees.map(f64::to_radians));
    let position = numbers::<3>(7, &cell)?;
    let turn = numbers::<3>(10, &cell)?.map(rotation_of);
    match (cell(0), joints, position, turn) {
        ("touch", Some(joints), None, None) => found.touches.push(Touch::Joints(joints)),
        ("touch", None, Some(position), Some(turn)) => {
            found.touches.push(Touch::Flange(Isometry3::from_parts(Translation3::from(position), turn)));
        }
        ("touch", ..) => {
            return Err("a touch has six joints, or the pose of the flange with its angles, one of the two".into());
        }
        ("pose", Some(joints), Some(position), rotation) => {
            found.poses.push(MeasuredPose { joints, position: position.into(), rotation });
        }
        ("pose", ..) => return Err("a pose has six joints and x_mm, y_mm and z_mm".into()),
        (other, ..) => return Err(format!("`{other}` is no kind: it must be `touch` or `pose`")),
    }
    Ok(())
}

/// Cells in a row from a column on: all numbers, or all empty.
fn numbers<'a, const K: usize>(first: usize, cell: &impl Fn(usize) -> &'a str) -> Result<Option<[f64; K]>, String> {
    let mut values = [0.0; K];
    let empty = (0..K).filter(|&k| cell(first + k).is_empty()).count();
    if empty == K {
        return Ok(None);
    }
    for (k, value) in values.iter_mut().enumerate() {
        let (name, text) = (COLUMNS[first + k], cell(first + k));
        if text.is_empty() {
            return Err(format!("{name} is empty, and others of its group are not"));
        }
        *value = text.parse::<f64>().map_err(|_| format!("{name}: `{text}` is not a number"))?;
        if value.is_nan() || value.abs() > MAX_COORDINATE {
            return Err(format!("{name} is {text}: it must be from -1e6 to 1e6"));
        }
    }
    Ok(Some(values))
}

/// Roll, pitch and yaw in degrees, as in URDF.
fn rotation_of(rpy_deg: [f64; 3]) -> UnitQuaternion<f64> {
    let [roll, pitch, yaw] = rpy_deg.map(f64::to_radians);
    UnitQuaternion::from_euler_angles(roll, pitch, yaw)
}

#[cfg(feature = "serde")]
mod json {
    use super::{MeasuredPose, MeasurementError, Measurements, Touch, rotation_of};
    use crate::json::JsonFault;
    use crate::pose::MAX_COORDINATE;
    use crate::workcell::FrameModel;
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};
    use serde::{Deserialize, Serialize};

    const VERSION: u32 = 1;

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        version: u32,
        #[serde(default)]
        touches: Vec<TouchModel>,
        #[serde(default)]
        poses: Vec<PoseModel>,
    }

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct TouchModel {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        joints_deg: Option<[f64; 6]>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        flange: Option<FrameModel>,
    }

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct PoseModel {
        joints_deg: [f64; 6],
        position_mm: [f64; 3],
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rpy_deg: Option<[f64; 3]>,
    }

    fn each<const K: usize>(path: &str, values: [f64; K]) -> Result<[f64; K], MeasurementError> {
        match values.iter().position(|value| value.is_nan() || value.abs() > MAX_COORDINATE) {
            Some(k) => Err(MeasurementError::Number { path: format!("{path}[{k}]"), value: values[k] }),
            None => Ok(values),
        }
    }

    fn degrees(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
        let (roll, pitch, yaw) = rotation.euler_angles();
        [roll, pitch, yaw].map(f64::to_degrees)
    }

    impl From<serde_json::Error> for MeasurementError {
        fn from(error: serde_json::Error) -> Self {
            match JsonFault::from(error) {
                JsonFault::Io(what) => MeasurementError::Io { what },
                JsonFault::At([line, column], what) => MeasurementError::Json { line, column, what },
            }
        }
    }

    impl Measurements {
        /// Reads a JSON file, as [`Measurements`] describes it.
        ///
        /// # Errors
        /// [`MeasurementError`] names line and column, or the field.
        pub fn from_json(input: impl std::io::Read) -> Result<Self, MeasurementError> {
            let file: File = serde_json::from_reader(input)?;
            if file.version != VERSION {
                return Err(MeasurementError::Version { found: file.version });
            }
            let mut found = Measurements::default();
            for (index, touch) in file.touches.into_iter().enumerate() {
                found.touches.push(match (touch.joints_deg, touch.flange) {
                    (Some(joints), None) => {
                        let joints = each(&format!("touches[{index}].joints_deg"), joints)?;
                        Touch::Joints(joints.map(f64::to_radians))
                    }
                    (None, Some(flange)) => {
                        let position = each(&format!("touches[{index}].flange.position_mm"), flange.position_mm)?;
                        let turn = each(&format!("touches[{index}].flange.rpy_deg"), flange.rpy_deg)?;
                        Touch::Flange(Isometry3::from_parts(Translation3::from(position), rotation_of(turn)))
                    }
                    _ => return Err(MeasurementError::Touch { index }),
                });
            }
            for (index, pose) in file.poses.into_iter().enumerate() {
                let joints = each(&format!("poses[{index}].joints_deg"), pose.joints_deg)?.map(f64::to_radians);
                let position = each(&format!("poses[{index}].position_mm"), pose.position_mm)?;
                let turn = pose.rpy_deg.map(|turn| each(&format!("poses[{index}].rpy_deg"), turn)).transpose()?;
                found.poses.push(MeasuredPose { joints, position: position.into(), rotation: turn.map(rotation_of) });
            }
            Ok(found)
        }

        /// Writes a JSON file that [`Measurements::from_json`] reads.
        ///
        /// # Errors
        /// [`MeasurementError::Io`].
        pub fn write_json(&self, mut output: impl std::io::Write) -> Result<(), MeasurementError> {
            let touch = |touch: &Touch| match touch {
                Touch::Joints(joints) => TouchModel { joints_deg: Some(joints.map(f64::to_degrees)), flange: None },
                Touch::Flange(pose) => {
                    let flange =
                        FrameModel { position_mm: pose.translation.vector.into(), rpy_deg: degrees(&pose.rotation) };
                    TouchModel { joints_deg: None, flange: Some(flange) }
                }
            };
            let pose = |pose: &MeasuredPose| PoseModel {
                joints_deg: pose.joints.map(f64::to_degrees),
                position_mm: pose.position.coords.into(),
                rpy_deg: pose.rotation.as_ref().map(degrees),
            };
            let file = File {
                version: VERSION,
                touches: self.touches.iter().map(touch).collect(),
                poses: self.poses.iter().map(pose).collect(),
            };
            let io = |error: std::io::Error| MeasurementError::Io { what: error.to_string() };
            serde_json::to_writer_pretty(&mut output, &file)?;
            writeln!(output).map_err(io)?;
            output.flush().map_err(io)
        }
    }
}
