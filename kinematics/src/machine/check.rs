//! From the numbers of a file to a machine, each checked under the name that it has in the file.

use super::error::MachineError;
use super::geometry::{AXES, FiveAxis, Linear, Rotary, Wrist};
use super::model::{AxisMount, LinearAxisModel, MachineKind, MachineModel, RotaryAxisModel, VERSION};
use super::rotate::{angle_about, arc};
use nalgebra::{Matrix3, Vector3};

/// Largest coordinate, mm.
const MAX_COORDINATE: f64 = 1e6;

/// Largest reading of a rotary axis, degrees: some 2,800 turns.
const MAX_DEGREES: f64 = 1e6;

/// Below this sine two directions count as parallel: the machine would turn about its pole for nearly all directions.
const PARALLEL: f64 = 1e-3;

/// The sine by which a polar head may tilt out of the plane of the linear axes: what is beyond would move the tip out of it, 1e-4 mm for 100 mm of nozzle.
const IN_PLANE: f64 = 1e-6;

const LINEAR_LETTERS: &str = "XYZUVW";
const ROTARY_LETTERS: &str = "ABCUVW";

fn wrong(path: impl Into<String>, value: f64, must: &'static str) -> MachineError {
    MachineError::Number { path: path.into(), value, must }
}

fn structure(path: impl Into<String>, what: &'static str) -> MachineError {
    MachineError::Structure { path: path.into(), what }
}

fn coordinates(path: &str, values: &[f64; 3]) -> Result<Vector3<f64>, MachineError> {
    for (k, &value) in values.iter().enumerate() {
        // NaN fails the comparison.
        if value.abs() > MAX_COORDINATE || value.is_nan() {
            return Err(wrong(format!("{path}[{k}]"), value, "a number from -1e6 to 1e6"));
        }
    }
    Ok(Vector3::from(*values))
}

fn direction(path: &str, values: &[f64; 3]) -> Result<Vector3<f64>, MachineError> {
    let direction = coordinates(path, values)?;
    direction.try_normalize(1e-9).ok_or_else(|| structure(path, "it is zero: give a direction"))
}

fn range(path: &str, [min, max]: [f64; 2], bound: f64, must: &'static str) -> Result<[f64; 2], MachineError> {
    for (k, value) in [min, max].into_iter().enumerate() {
        if value.abs() > bound || value.is_nan() {
            return Err(wrong(format!("{path}[{k}]"), value, must));
        }
    }
    if min < max { Ok([min, max]) } else { Err(MachineError::EmptyRange { path: path.into(), min, max }) }
}

fn positive(path: String, value: f64) -> Result<f64, MachineError> {
    if value > 0.0 && value <= 1e9 { Ok(value) } else { Err(wrong(path, value, "above 0 and at most 1e9")) }
}

fn acceleration(path: String, value: Option<f64>) -> Result<f64, MachineError> {
    value.map_or(Ok(f64::INFINITY), |value| positive(path, value))
}

fn linear(path: &str, axis: &LinearAxisModel) -> Result<Linear, MachineError> {
    Ok(Linear {
        range: range(&format!("{path}.range_mm"), axis.range_mm, MAX_COORDINATE, "a number from -1e6 to 1e6")?,
        speed: positive(format!("{path}.max_speed_mm_s"), axis.max_speed_mm_s)?,
        acceleration: acceleration(format!("{path}.max_acceleration_mm_s2"), axis.max_acceleration_mm_s2)?,
    })
}

fn rotary(path: &str, axis: &RotaryAxisModel) -> Result<Rotary, MachineError> {
    let missing = |field: &str, what| MachineError::Missing { path: format!("{path}.{field}"), what };
    let point = axis.point_mm.ok_or_else(|| {
        missing("point_mm", "a point on the axis in the machine frame, in mm, as measured at the zero posture")
    })?;
    let must = "a number of degrees from -1e6 to 1e6";
    let ends = match (axis.range_deg, axis.endless) {
        (Some(_), true) => {
            return Err(structure(format!("{path}.range_deg"), "an endless axis has no range: leave one of both out"));
        }
        (None, false) => return Err(missing("range_deg", "[min, max] in degrees, or `\"endless\": true`")),
        (None, true) => [f64::NEG_INFINITY, f64::INFINITY],
        (Some(ends), false) => range(&format!("{path}.range_deg"), ends, MAX_DEGREES, must)?.map(f64::to_radians),
    };
    if axis.zero_deg.abs() > MAX_DEGREES || axis.zero_deg.is_nan() {
        return Err(wrong(format!("{path}.zero_deg"), axis.zero_deg, must));
    }
    Ok(Rotary {
        is_table: axis.mount == AxisMount::Table,
        axis: direction(&format!("{path}.axis"), &axis.axis)?,
        point: coordinates(&format!("{path}.point_mm"), &point)?,
        zero: axis.zero_deg.to_radians(),
        range: ends,
        speed: positive(format!("{path}.max_speed_deg_s"), axis.max_speed_deg_s)?.to_radians(),
        acceleration: acceleration(format!("{path}.max_acceleration_deg_s2"), axis.max_acceleration_deg_s2)?
            .to_radians(),
    })
}

/// The letters in the order of the values, each known and there once.
fn letters(model: &MachineModel) -> Result<[char; AXES], MachineError> {
    let mut letters = ['\0'; AXES];
    let linear = model.linear.iter().enumerate().map(|(k, axis)| (format!("linear[{k}]"), axis.letter, LINEAR_LETTERS));
    let rotary = model.rotary.iter().enumerate().map(|(k, axis)| (format!("rotary[{k}]"), axis.letter, ROTARY_LETTERS));
    let mut paths: Vec<String> = Vec::with_capacity(AXES);
    for (path, letter, known) in linear.chain(rotary) {
        let field = format!("{path}.letter");
        if !known.contains(letter) {
            return Err(MachineError::Letter { path: field, letter, known });
        }
        if let Some(other) = letters[..paths.len()].iter().position(|&other| other == letter) {
            return Err(MachineError::SameLetter { path: field, letter, other: paths[other].clone() });
        }
        letters[paths.len()] = letter;
        paths.push(path);
    }
    Ok(letters)
}

/// The kind by what the rotary axes move.
fn kind(model: &MachineModel, rotary: &[Rotary; 2]) -> Result<MachineKind, MachineError> {
    let kind = match rotary.map(|axis| axis.is_table) {
        [true, true] => MachineKind::TableTable,
        [true, false] => MachineKind::HeadTable,
        [false, false] => MachineKind::HeadHead,
        [false, true] => {
            let what = "a table axis comes before a head axis: list the axes from the part to the nozzle";
            return Err(structure("rotary[1].mount", what));
        }
    };
    match (model.linear.len(), kind) {
        (3, kind) => Ok(kind),
        (2, MachineKind::HeadTable) => Ok(MachineKind::PolarHead),
        (2, _) => Err(structure(
            "linear",
            "with two linear axes the table must turn and the head tilt: give three, or one axis of each mount",
        )),
        _ => Err(structure(
            "linear",
            "a five-axis machine has three linear axes (or two with a turning table and a tilting head)",
        )),
    }
}

/// The directions of the linear axes as columns, the way back as rows, and what is across two of them.
fn frame(model: &MachineModel, kind: MachineKind) -> Result<[Matrix3<f64>; 2], MachineError> {
    let mut columns = Matrix3::zeros();
    for (k, axis) in model.linear.iter().enumerate() {
        columns.set_column(k, &direction(&format!("linear[{k}].direction"), &axis.direction)?);
    }
    let mut square = columns;
    if kind == MachineKind::PolarHead {
        let across = columns.column(0).cross(&columns.column(1));
        let across = across.try_normalize(PARALLEL).ok_or_else(|| structure("linear[1].direction", DEPENDENT))?;
        square.set_column(2, &across);
    }
    if square.determinant().abs() < PARALLEL {
        return Err(structure(format!("linear[{}].direction", model.linear.len() - 1), DEPENDENT));
    }
    let inverse = square.try_inverse().ok_or_else(|| structure("linear", DEPENDENT))?;
    Ok([square, inverse])
}

const DEPENDENT: &str = "the linear axes do not span the space: give each a direction of its own";

/// The rotary axes and the nozzle must turn what they should.
fn check_angles(rotary: &[Rotary; 2], nozzle: &Vector3<f64>) -> Result<(), MachineError> {
    let [first, second] = rotary;
    if first.axis.cross(&second.axis).norm() < PARALLEL {
        let what =
            "it is parallel to rotary[0].axis, so that both do the same: give the axes as they are at the zero posture";
        return Err(structure("rotary[1].axis", what));
    }
    if second.axis.cross(nozzle).norm() < PARALLEL {
        let what =
            "it is parallel to rotary[1].axis, which then does nothing: list the axes from the part to the nozzle";
        return Err(structure("nozzle.direction", what));
    }
    Ok(())
}

/// A polar machine: the head must tilt in the plane of the linear axes.
fn check_polar(model: &MachineModel, rotary: &[Rotary; 2], across: &Vector3<f64>) -> Result<(), MachineError> {
    if rotary[1].axis.cross(across).norm() > IN_PLANE {
        let what = "with two linear axes the head must tilt in their plane: give an axis at right angles to both";
        return Err(structure("rotary[1].axis", what));
    }
    if model.tcp {
        let what = "a machine with two linear axes has no X Y Z of the tip: set it to false";
        return Err(structure("tcp", what));
    }
    Ok(())
}

/// With `tcp` the first three values are the tip along x, y and z.
fn check_tcp(model: &MachineModel, letters: &[char; AXES]) -> Result<(), MachineError> {
    if model.tcp && letters[..3] != ['X', 'Y', 'Z'] {
        return Err(structure(
            "tcp",
            "the linear axes must be X, Y and Z in this order: rename them, or set it to false",
        ));
    }
    Ok(())
}

/// The tip at the zero posture, in the machine frame.
fn tip(model: &MachineModel, rotary: &[Rotary; 2]) -> Result<Vector3<f64>, MachineError> {
    let path = "nozzle.tip_mm";
    let pivot = rotary.iter().rev().find(|axis| !axis.is_table).map(|axis| axis.point);
    match (model.nozzle.tip_mm, pivot) {
        (Some(tip), pivot) => Ok(coordinates(path, &tip)? + pivot.unwrap_or_default()),
        (None, None) => Ok(Vector3::zeros()),
        (None, Some(_)) => {
            let what = "the tip from point_mm of the last head axis, in mm: [0, 0, -L] for a nozzle of length L";
            Err(MachineError::Missing { path: path.into(), what })
        }
    }
}

impl FiveAxis {
    /// Checks the numbers of a machine.
    ///
    /// # Errors
    /// [`MachineError`] names the field, as in the file, and says what to do.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::machine::{
    ///     AxisMount, FiveAxis, LinearAxisModel, MachineKind, MachineModel, RotaryAxisModel, ToolModel, VERSION,
    /// };
    /// let linear = |letter, direction| LinearAxisModel {
    ///     letter, direction, range_mm: [-200.0, 200.0], max_speed_mm_s: 150.0, max_acceleration_mm_s2: None,
    /// };
    /// let rotary = |letter, axis, range_deg: Option<[f64; 2]>| RotaryAxisModel {
    ///     letter, mount: AxisMount::Table, axis, point_mm: Some([0.0; 3]), zero_deg: 0.0,
    ///     endless: range_deg.is_none(), range_deg, max_speed_deg_s: 90.0, max_acceleration_deg_s2: None,
    /// };
    /// let machine = FiveAxis::new(MachineModel {
    ///     version: VERSION,
    ///     name: "a trunnion with a turntable".into(),
    ///     source: None,
    ///     dialect: None,
    ///     tcp: false,
    ///     linear: vec![linear('X', [1.0, 0.0, 0.0]), linear('Y', [0.0, 1.0, 0.0]), linear('Z', [0.0, 0.0, 1.0])],
    ///     rotary: vec![rotary('C', [0.0, 0.0, 1.0], None), rotary('A', [1.0, 0.0, 0.0], Some([-90.0, 90.0]))],
    ///     nozzle: ToolModel { direction: ToolModel::UPRIGHT, tip_mm: None },
    ///     part_origin_mm: [0.0; 3],
    /// })?;
    /// assert_eq!((machine.kind(), machine.letters()), (MachineKind::TableTable, &['X', 'Y', 'Z', 'C', 'A'][..]));
    /// // The table tilts by a quarter turn: what was up points to -y, and the nozzle comes from the part's y.
    /// let (_, direction) = machine.forward(&[0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2]);
    /// assert!((direction.y - 1.0).abs() < 1e-12);
    /// # Ok::<(), curvlay_kinematics::machine::MachineError>(())
    /// ```
    pub fn new(model: MachineModel) -> Result<Self, MachineError> {
        if model.version != VERSION {
            return Err(MachineError::Version { found: model.version });
        }
        if model.name.trim().is_empty() {
            return Err(structure("name", "it is empty: give the machine a name"));
        }
        let [first, second] = &model.rotary[..] else {
            return Err(structure(
                "rotary",
                "a five-axis machine has two rotary axes: give two, from the part to the nozzle",
            ));
        };
        let letters = letters(&model)?;
        let rotary = [rotary("rotary[0]", first)?, rotary("rotary[1]", second)?];
        let kind = kind(&model, &rotary)?;
        let axes = model.linear.iter().enumerate().map(|(k, axis)| linear(&format!("linear[{k}]"), axis));
        let axes: Vec<Linear> = axes.collect::<Result<_, _>>()?;
        let nozzle = direction("nozzle.direction", &model.nozzle.direction)?;
        let tip = tip(&model, &rotary)?;
        let origin = coordinates("part_origin_mm", &model.part_origin_mm)?;
        check_angles(&rotary, &nozzle)?;
        let [mut columns, mut rows] = frame(&model, kind)?;
        let across: Vector3<f64> = columns.column(2).into();
        if kind == MachineKind::PolarHead {
            check_polar(&model, &rotary, &across)?;
            columns.fill_column(2, 0.0);
            rows.fill_row(2, 0.0);
        }
        check_tcp(&model, &letters)?;
        let [first, second] = &rotary;
        let wrist = Wrist {
            axes: arc(&first.axis, &second.axis),
            nozzle: arc(&second.axis, &nozzle),
            upright: angle_about(&second.axis, &nozzle, &first.axis),
        };
        Ok(FiveAxis { model, kind, letters, linear: axes, rotary, columns, rows, across, tip, nozzle, origin, wrist })
    }
}
