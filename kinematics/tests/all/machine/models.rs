//! Machines that tests share, and invalid models.

use curvlay_kinematics::machine::{
    AxisMount, FiveAxis, LinearAxisModel, MachineError, MachineKind, MachineModel, RotaryAxisModel, ToolModel, VERSION,
};

pub fn linear(letter: char, direction: [f64; 3]) -> LinearAxisModel {
    LinearAxisModel {
        letter,
        direction,
        range_mm: [-500.0, 500.0],
        max_speed_mm_s: 100.0,
        max_acceleration_mm_s2: Some(1000.0),
    }
}

pub fn rotary(letter: char, mount: AxisMount, axis: [f64; 3], range_deg: Option<[f64; 2]>) -> RotaryAxisModel {
    RotaryAxisModel {
        letter,
        mount,
        axis,
        point_mm: Some([0.0; 3]),
        zero_deg: 0.0,
        range_deg,
        endless: range_deg.is_none(),
        max_speed_deg_s: 90.0,
        max_acceleration_deg_s2: Some(900.0),
    }
}

pub const X: [f64; 3] = [1.0, 0.0, 0.0];
pub const Y: [f64; 3] = [0.0, 1.0, 0.0];
pub const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// A machine of each kind, with offsets in all places.
pub fn model(kind: MachineKind) -> MachineModel {
    use AxisMount::{Head, Table};
    let mut linears = vec![linear('X', X), linear('Y', Y), linear('Z', Z)];
    let (mut rotaries, tip_mm) = match kind {
        MachineKind::TableTable => {
            (vec![rotary('C', Table, Z, None), rotary('A', Table, X, Some([-120.0, 120.0]))], Some([1.0, -2.0, 3.0]))
        }
        MachineKind::HeadTable => (
            vec![rotary('C', Table, Z, Some([-400.0, 400.0])), rotary('B', Head, Y, Some([-100.0, 100.0]))],
            Some([0.5, 0.0, -60.0]),
        ),
        MachineKind::HeadHead => (
            vec![rotary('C', Head, Z, Some([-360.0, 360.0])), rotary('A', Head, X, Some([-110.0, 110.0]))],
            Some([0.0, 2.0, -80.0]),
        ),
        MachineKind::PolarHead => {
            linears.remove(1);
            (vec![rotary('C', Table, Z, None), rotary('B', Head, Y, Some([-90.0, 90.0]))], Some([0.0, 0.0, -50.0]))
        }
    };
    let points = match kind {
        MachineKind::TableTable => [[0.3, -0.2, 5.0], [10.0, 1.0, -40.0]],
        MachineKind::HeadTable => [[2.0, 3.0, 0.0], [0.0, 4.0, 60.0]],
        MachineKind::HeadHead => [[1.0, 0.0, 100.0], [1.0, -1.5, 80.0]],
        MachineKind::PolarHead => [[0.0; 3], [0.0, 0.0, 50.0]],
    };
    for (axis, point) in rotaries.iter_mut().zip(points) {
        axis.point_mm = Some(point);
    }
    MachineModel {
        version: VERSION,
        name: format!("{kind:?}"),
        source: None,
        dialect: None,
        tcp: false,
        linear: linears,
        rotary: rotaries,
        nozzle: ToolModel { direction: Z, tip_mm },
        part_origin_mm: if kind == MachineKind::PolarHead { [0.0; 3] } else { [7.0, -8.0, 9.0] },
    }
}

pub const KINDS: [MachineKind; 4] =
    [MachineKind::TableTable, MachineKind::HeadTable, MachineKind::HeadHead, MachineKind::PolarHead];

pub fn machine(kind: MachineKind) -> FiveAxis {
    FiveAxis::new(model(kind)).unwrap()
}

/// What is said of a model after a change.
fn refusal(kind: MachineKind, change: impl FnOnce(&mut MachineModel)) -> String {
    let mut model = model(kind);
    change(&mut model);
    FiveAxis::new(model).unwrap_err().to_string()
}

#[test]
fn kinds_are_recognised() {
    for kind in KINDS {
        let machine = machine(kind);
        assert_eq!(machine.kind(), kind);
        assert_eq!(machine.letters().len(), if kind == MachineKind::PolarHead { 4 } else { 5 });
        assert_eq!(machine.linear_count() + 2, machine.letters().len());
    }
    let ranges = machine(MachineKind::HeadTable).ranges();
    assert!((ranges[0][0] + 500.0).abs() < 1e-12 && (ranges[0][1] - 500.0).abs() < 1e-12);
    assert!((ranges[3][1] - 400f64.to_radians()).abs() < 1e-12);
    assert!(machine(MachineKind::PolarHead).ranges()[2][0].is_infinite());
}

#[test]
fn each_fault_has_its_line() {
    use MachineKind::{HeadHead, HeadTable, PolarHead, TableTable};
    let missing = "rotary[1].point_mm is missing: give a point on the axis in the machine frame, in mm, as measured at the zero posture";
    assert_eq!(refusal(HeadHead, |m| m.rotary[1].point_mm = None), missing);
    let same = "rotary[1].letter: the letter `C` is that of rotary[0] already; give each axis its own";
    assert_eq!(refusal(TableTable, |m| m.rotary[1].letter = 'C'), same);
    assert!(
        refusal(TableTable, |m| m.linear[1].letter = 'X')
            .starts_with("linear[1].letter: the letter `X` is that of linear[0]")
    );
    assert!(
        refusal(TableTable, |m| m.linear[1].letter = 'E')
            .contains("`E` is no letter of such an axis; known are XYZUVW")
    );
    assert!(refusal(TableTable, |m| m.rotary[1].letter = 'x').contains("known are ABCUVW"));
    assert!(
        refusal(TableTable, |m| m.rotary[1].axis = [0.0, 0.0, -3.0])
            .starts_with("rotary[1].axis: it is parallel to rotary[0].axis")
    );
    assert!(
        refusal(HeadHead, |m| m.nozzle.direction = X).starts_with("nozzle.direction: it is parallel to rotary[1].axis")
    );
    assert_eq!(
        refusal(HeadTable, |m| m.rotary[0].range_deg = Some([90.0, 90.0])),
        "rotary[0].range_deg is empty: 90 to 90; give the lower end first"
    );
    assert_eq!(
        refusal(HeadTable, |m| m.linear[2].range_mm = [5.0, -5.0]),
        "linear[2].range_mm is empty: 5 to -5; give the lower end first"
    );
    assert!(
        refusal(HeadTable, |m| m.rotary[0].range_deg = None)
            .starts_with("rotary[0].range_deg is missing: give [min, max]")
    );
    assert!(refusal(HeadTable, |m| m.rotary[0].endless = true).contains("an endless axis has no range"));
    assert!(refusal(HeadTable, |m| m.nozzle.tip_mm = None).starts_with("nozzle.tip_mm is missing"));
    assert!(refusal(HeadTable, |m| m.nozzle.direction = [0.0; 3]).starts_with("nozzle.direction: it is zero"));
    assert!(refusal(HeadTable, |m| m.rotary.reverse()).starts_with("rotary[1].mount: a table axis comes before"));
    assert!(
        refusal(HeadTable, |m| m.linear[2].direction = [1.0, 1.0, 0.0])
            .starts_with("linear[2].direction: the linear axes do not span")
    );
    assert!(
        refusal(PolarHead, |m| m.linear[1].direction = X)
            .starts_with("linear[1].direction: the linear axes do not span")
    );
    assert!(refusal(PolarHead, |m| m.rotary[1].axis = [1.0, 1.0, 0.0]).contains("the head must tilt in their plane"));
    assert!(refusal(PolarHead, |m| m.tcp = true).starts_with("tcp: a machine with two linear axes"));
    assert!(refusal(TableTable, |m| m.linear.truncate(2)).starts_with("linear: with two linear axes"));
    assert!(refusal(TableTable, |m| m.linear.truncate(1)).starts_with("linear: a five-axis machine has three"));
    assert!(
        refusal(TableTable, |m| m.rotary.truncate(1)).starts_with("rotary: a five-axis machine has two rotary axes")
    );
    assert!(refusal(TableTable, |m| m.name = " ".into()).starts_with("name: it is empty"));
    let swap = |m: &mut MachineModel| {
        m.tcp = true;
        m.linear.swap(0, 1);
    };
    assert!(refusal(TableTable, swap).starts_with("tcp: the linear axes must be X, Y and Z"));
    let mut newer = model(TableTable);
    newer.version = 2;
    assert_eq!(FiveAxis::new(newer), Err(MachineError::Version { found: 2 }));
}

/// Every number of a model, set to invalid values.
#[test]
fn numbers_that_are_not_finite_are_named() {
    type Field = (&'static str, fn(&mut MachineModel) -> &mut f64);
    let fields: [Field; 12] = [
        ("linear[0].direction[1]", |m| &mut m.linear[0].direction[1]),
        ("linear[1].range_mm[0]", |m| &mut m.linear[1].range_mm[0]),
        ("linear[1].range_mm[1]", |m| &mut m.linear[1].range_mm[1]),
        ("linear[2].max_speed_mm_s", |m| &mut m.linear[2].max_speed_mm_s),
        ("linear[2].max_acceleration_mm_s2", |m| m.linear[2].max_acceleration_mm_s2.as_mut().unwrap()),
        ("rotary[0].axis[2]", |m| &mut m.rotary[0].axis[2]),
        ("rotary[0].zero_deg", |m| &mut m.rotary[0].zero_deg),
        ("rotary[1].range_deg[1]", |m| &mut m.rotary[1].range_deg.as_mut().unwrap()[1]),
        ("rotary[1].max_speed_deg_s", |m| &mut m.rotary[1].max_speed_deg_s),
        ("rotary[1].max_acceleration_deg_s2", |m| m.rotary[1].max_acceleration_deg_s2.as_mut().unwrap()),
        ("nozzle.tip_mm[2]", |m| &mut m.nozzle.tip_mm.as_mut().unwrap()[2]),
        ("part_origin_mm[0]", |m| &mut m.part_origin_mm[0]),
    ];
    for (path, field) in fields {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e10] {
            let said = refusal(MachineKind::HeadHead, |m| *field(m) = value);
            assert!(said.starts_with(&format!("{path} is {value}: it must be ")), "{path}: {said}");
        }
    }
    for value in [0.0, -1.0] {
        let said = refusal(MachineKind::HeadHead, |m| m.rotary[1].max_speed_deg_s = value);
        assert!(said.contains("above 0"), "{said}");
    }
}
