//! Files of machines: the ones to copy from, written and read again, and invalid ones.

use curvlay_kinematics::machine::{FiveAxis, MachineKind, MachineModel};
use curvlay_kinematics::nalgebra::{Point3, Vector3};

pub const FILES: [(&str, &str, MachineKind); 5] = [
    ("open5x-table", include_str!("../../../../examples/machines/open5x-table.json"), MachineKind::TableTable),
    ("bc-table-tcp", include_str!("../../../../examples/machines/bc-table-tcp.json"), MachineKind::TableTable),
    (
        "klipper-tilting-head",
        include_str!("../../../../examples/machines/klipper-tilting-head.json"),
        MachineKind::HeadTable,
    ),
    ("head-head-gantry", include_str!("../../../../examples/machines/head-head-gantry.json"), MachineKind::HeadHead),
    (
        "polar-tilting-head",
        include_str!("../../../../examples/machines/polar-tilting-head.json"),
        MachineKind::PolarHead,
    ),
];

fn written(model: &MachineModel) -> String {
    let mut file = vec![];
    model.write_json(&mut file).unwrap();
    String::from_utf8(file).unwrap()
}

#[test]
fn files_to_copy_from_are_read_and_come_back() {
    for (name, text, kind) in FILES {
        let machine = FiveAxis::from_json(text.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(machine.kind(), kind, "{name}");
        let model = machine.model();
        assert!(model.source.as_ref().is_some_and(|source| source.len() > 40), "{name} has no source");
        assert!(model.dialect.is_some(), "{name} has no dialect");
        assert_eq!(&MachineModel::from_json(written(model).as_bytes()).unwrap(), model, "{name}");
        // An upright nozzle over the plate is in reach of all.
        let tip = Point3::new(10.0, 5.0, 20.0);
        assert!(machine.inverse(&tip, &Vector3::z_axis(), &machine.start()).count() > 0, "{name}");
    }
    // All files of the folder are in the list.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/machines");
    let mut names: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let mut listed = FILES.map(|(name, ..)| format!("{name}.json"));
    listed.sort();
    assert_eq!(names, listed);
}

#[test]
fn invalid_files_say_where() {
    let (_, text, _) = FILES[0];
    let said = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        FiveAxis::from_json(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
    };
    let unknown = said("\"max_speed_mm_s\": 200,", "\"speed\": 200,");
    assert!(unknown.starts_with("line 8, column ") && unknown.contains("unknown field `speed`"), "{unknown}");
    assert!(said("\"tcp\": false,", "").contains("missing field `tcp`"));
    assert!(
        said("\"mount\": \"table\"", "\"mount\": \"bed\"")
            .contains("unknown variant `bed`, expected `table` or `head`")
    );
    assert!(said("\"letter\": \"X\"", "\"letter\": \"XY\"").starts_with("line 8, column"));
    assert!(
        said("\"letter\": \"X\"", "\"letter\": \"Z\"")
            .starts_with("linear[2].letter: the letter `Z` is that of linear[0]")
    );
    assert!(said(", \"point_mm\": [0, 0, -40]", "").starts_with("rotary[1].point_mm is missing"));
    assert_eq!(said("\"version\": 1,", "\"version\": 3, \"new\": 1,"), "version: 3 is not known, only 1 is");
    assert!(FiveAxis::from_json(&b""[..]).is_err() && FiveAxis::from_json(&b"\xff"[..]).is_err());
    for end in 0..text.trim_end().len() {
        assert!(FiveAxis::from_json(&text.as_bytes()[..end]).is_err(), "{end}");
    }
    let mut model = MachineModel::from_json(text.as_bytes()).unwrap();
    model.linear[0].range_mm[1] = f64::NAN;
    let error = model.write_json(std::io::sink()).unwrap_err().to_string();
    assert!(error.starts_with("linear[0].range_mm[1] is NaN"), "{error}");
}

/// The names of all fields in a file.
fn keys(value: &serde_json::Value, found: &mut Vec<String>) {
    if let Some(object) = value.as_object() {
        found.extend(object.keys().cloned());
        object.values().for_each(|value| keys(value, found));
    }
    value.as_array().into_iter().flatten().for_each(|value| keys(value, found));
}

/// A row `| name |` for each field, and no row for what is no field.
#[test]
fn every_field_is_on_the_page() {
    let page = include_str!("../../../../docs/formats/machines.md");
    let mut found = vec![];
    for (_, text, _) in FILES {
        let model = MachineModel::from_json(text.as_bytes()).unwrap();
        keys(&serde_json::to_value(model).unwrap(), &mut found);
    }
    found.sort();
    found.dedup();
    let rows: Vec<_> = page.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    for key in &found {
        assert!(rows.contains(&key.as_str()), "docs/formats/machines.md has no row for `{key}`");
    }
    let mut named: Vec<_> = rows.iter().map(|row| (*row).to_owned()).collect();
    named.sort();
    named.dedup();
    assert_eq!(named, found, "rows of docs/formats/machines.md");
    for (name, ..) in FILES {
        assert!(page.contains(&format!("{name}.json")), "{name} is not on the page");
    }
}
