//! Plain G-code of a table that tilts and turns: as it is planned, and with one fault each.

use super::*;
use curvlay_toolpath::gcode::RotaryTable;
use serde_json::json;

/// Tilt and turn of the table along x.
fn angles(at: &[f64; 3]) -> [f64; 2] {
    [0.1 * (at[0] / 30.0), 0.4 + 0.02 * at[1]]
}

/// The paths in steps of half a millimetre.
fn fine() -> Vec<Vec<[f64; 3]>> {
    let step = |two: &[[f64; 3]]| {
        let length = (Vector3::from(two[1]) - Vector3::from(two[0])).norm();
        let count = (length / 0.5).ceil() as u32;
        let (from, to) = (two[0], two[1]);
        (1..=count).map(move |k| [0, 1, 2].map(|c| from[c] + f64::from(k) / f64::from(count) * (to[c] - from[c])))
    };
    paths().iter().map(|path| std::iter::once(path[0]).chain(path.windows(2).flat_map(step)).collect()).collect()
}

/// The file of the machine that is the default, changed.
fn bc_table(change: impl FnOnce(&mut Value, &mut Value)) -> String {
    let mut file: Value = serde_json::from_str(include_str!("../../../replay/machine/table.json")).unwrap();
    let [turn, tilt] = file["rotary"].as_array_mut().unwrap().as_mut_slice() else { panic!("two rotary axes") };
    change(turn, tilt);
    file.to_string()
}

/// G-code for a table: each step takes the time that the tip needs.
fn gcode(table: &RotaryTable, travel_z: f64) -> String {
    leaning(table, travel_z, 0.0)
}

/// The same with the tilt of the table off by so much: X, Y and Z make up for it, so that the tip is right.
fn leaning(table: &RotaryTable, travel_z: f64, off: f64) -> String {
    let mut text = String::from("G28\nG21\nG90\nG94\nM82\nG92 E0\n");
    let mut filament = 0.0;
    let axes = |at: &[f64; 3]| {
        let [b, c] = [angles(at)[0] + off, angles(at)[1]];
        let p = table.machine_point(&Point3::from(*at), [b, c]);
        format!("X{:.4} Y{:.4} Z{:.4} B{:.5} C{:.5}", p.x, p.y, p.z, b.to_degrees(), c.to_degrees())
    };
    let raised = |at: &[f64; 3]| [at[0], at[1], at[2] + travel_z];
    for path in fine() {
        let end = path[path.len() - 1];
        let _ = writeln!(text, "G0 {} F2400\nG0 {}\nG93", axes(&raised(&path[0])), axes(&path[0]));
        for two in path.windows(2) {
            let length = (Vector3::from(two[1]) - Vector3::from(two[0])).norm();
            filament += FEED * length;
            let _ = writeln!(text, "G1 {} E{filament:.5} F{:.6}", axes(&two[1]), 60.0 * SPEED / length);
        }
        let _ = writeln!(text, "G94\nG0 {} F2400", axes(&raised(&end)));
    }
    text
}

fn gcode_run(name: &str, text: &str, more: &[&str]) -> Map<String, Value> {
    let inputs = folder(name);
    let table = RotaryTable::default();
    let direction = |at: &[f64; 3]| table.part_point(&Point3::origin(), angles(at)).1.into_inner();
    let (program, plan) = (file(&inputs, "part.gcode", text), plan(&inputs, &fine(), direction));
    run(name, &[&[program.as_str(), "--plan", &plan], more].concat()).unwrap()
}

#[test]
fn rotary_gcode_is_what_was_planned() {
    // Eleven seconds with six ways up and down, each from rest to rest: their accelerations are a larger share than in a print.
    let more = ["--joints", "--allow-time", "0.015"];
    let summary = gcode_run("rotary", &gcode(&RotaryTable::default(), 10.0), &more);
    assert_eq!(failed(&summary), Vec::<String>::new());
    assert!((figure(&summary, "time_s") / figure(&summary, "programmed_s") - 1.0).abs() < 0.015);
    assert!(figure(&summary, "tip_off_mm") < 0.1, "{}", figure(&summary, "tip_off_mm"));
    assert!((figure(&summary, "filament_mm") - 105.0 * FEED).abs() < 1e-3);
    let table = fs::read_to_string(common::place("replay", "rotary").join("joints.csv")).unwrap();
    assert!(table.starts_with("time_s,X,Y,Z,C,B,x_mm,y_mm,z_mm,i,j,k,filament_mm,file,step\n"));
    assert_eq!(Some(table.lines().count() as u64 - 1), summary["ticks"].as_u64());
}

#[test]
fn a_pivot_that_is_off_puts_the_whole_program_off() {
    let mut table = RotaryTable::default();
    table.tilt.centre.x += 2.0;
    table.turn.centre.y += 2.0;
    let summary = gcode_run("pivot", &gcode(&table, 10.0), &[]);
    assert!(has(&summary, "the tip is off the planned path"), "{:?}", failed(&summary));
    assert!(summary["findings"].as_str().unwrap().contains("the whole program is off"), "{}", summary["findings"]);
    // On a machine that is so it is right.
    let description = bc_table(|turn, tilt| {
        tilt["point_mm"] = json!([2, 0, 0]);
        turn["point_mm"] = json!([0, 2, 0]);
    });
    let machine = file(&folder("pivot"), "machine.json", &description);
    let summary = gcode_run(
        "pivot-right",
        &gcode(&table, 10.0),
        &["--machine", &machine, "--flavour", "plain", "--allow-time", "0.015"],
    );
    assert_eq!(failed(&summary), Vec::<String>::new());
}

#[test]
fn a_nozzle_that_leans_otherwise_is_caught_though_its_tip_is_right() {
    let more = ["--allow-time", "0.015"];
    let summary = gcode_run("leaning", &leaning(&RotaryTable::default(), 10.0, 0.15), &more);
    assert_eq!(failed(&summary).len(), 1, "{:?}", failed(&summary));
    assert!(has(&summary, "the nozzle direction differs from the plan: 8.59 degrees"), "{:?}", failed(&summary));
    assert!(summary["findings"].as_str().unwrap().contains("the whole program is off"), "{}", summary["findings"]);
    assert!(
        figure(&summary, "tip_off_mm") < 0.1 && (figure(&summary, "tilt_off_deg") - 0.15f64.to_degrees()).abs() < 0.05
    );
    let summary = gcode_run(
        "leaning",
        &leaning(&RotaryTable::default(), 10.0, 0.15),
        &[&more[..], &["--allow-tilt", "9"]].concat(),
    );
    assert_eq!(failed(&summary), Vec::<String>::new());
}

#[test]
fn lines_that_are_lost_are_left_out() {
    let text = gcode(&RotaryTable::default(), 10.0);
    let mut lines: Vec<&str> = text.lines().collect();
    // Around the first corner.
    let first = lines.iter().position(|line| line.starts_with("G1")).unwrap() + 58;
    lines.drain(first..first + 4);
    let summary = gcode_run("lost-lines", &(lines.join("\n") + "\n"), &["--allow-time", "0.15"]);
    assert!(has(&summary, "planned ways are left out"), "{:?}", failed(&summary));
}

#[test]
fn a_travel_through_what_is_built_is_a_contact() {
    let text = gcode(&RotaryTable::default(), 10.0) + "G0 X0 Y-20 Z20 B0 C0 F2400\nG0 Z0.1\nG0 Y25\nG0 Z20\n";
    let summary = gcode_run("contact", &text, &["--allow-time", "0.15"]);
    assert!(has(&summary, "the nozzle is in what is built"), "{:?}", failed(&summary));
    let text = gcode(&RotaryTable::default(), 10.0) + "G0 X0 Y-20 Z20 B0 C0 F2400\nG0 Z-1\nG0 Z20\n";
    let summary = gcode_run("plate", &text, &["--allow-time", "0.15"]);
    assert!(has(&summary, "the nozzle is in the plate: once"), "{:?}", failed(&summary));
    assert!((figure(&summary, "max_plate_contact_mm") - 1.0).abs() < 0.3);
}

#[test]
fn a_slow_axis_takes_longer_and_lays_too_much() {
    let description = bc_table(|_, tilt| tilt["max_speed_deg_s"] = json!(0.5));
    let machine = file(&folder("slow"), "machine.json", &description);
    let summary =
        gcode_run("slow", &gcode(&RotaryTable::default(), 10.0), &["--machine", &machine, "--flavour", "plain"]);
    assert!(has(&summary, "the program takes another time than programmed"), "{:?}", failed(&summary));
}

/// Every key of the summary stands in the description of formats, and every column.
#[test]
fn the_keys_are_described() {
    let summary = gcode_run("keys", &gcode(&RotaryTable::default(), 10.0), &[]);
    let page = common::formats(Some("replay.md"));
    for key in summary.keys() {
        assert!(page.contains(&format!("`{key}`")), "{key} is not in docs/formats/replay.md");
    }
    let head = fs::read_to_string(common::place("replay", "keys").join("limits.csv")).unwrap();
    for column in head.lines().next().unwrap().split(',') {
        assert!(page.contains(column), "{column}");
    }
}
