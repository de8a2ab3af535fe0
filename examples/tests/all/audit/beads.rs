//! Programs with faults of known length, the same program in other words, and a slow twin.

use super::{assert_refused, count_of, input, run};
use crate::common;
use proptest::prelude::*;
use serde_json::{Map, Value};
use std::fmt::Write;
use std::fs;

const WIDTH: f64 = 1.0;
const HEIGHT: f64 = 0.5;
/// Filament for a millimetre of a bead with round rims, of 1.75 mm.
const FEED: f64 =
    (WIDTH * HEIGHT - HEIGHT * HEIGHT * (1.0 - std::f64::consts::FRAC_PI_4)) / (std::f64::consts::PI * 0.875 * 0.875);

/// Straight beads, each an extrusion of its own: from, to.
fn gcode(beads: &[[[f64; 3]; 2]]) -> String {
    let mut text = "G28\nG21\nG90\nM83\nM117 of a test\n".to_owned();
    for [from, to] in beads {
        let length = (0..3).map(|k| (to[k] - from[k]).powi(2)).sum::<f64>().sqrt();
        writeln!(text, "G0 X{} Y{} Z{} F6000", from[0], from[1], from[2]).unwrap();
        writeln!(text, "G1 X{} Y{} Z{} E{:.7} F600", to[0], to[1], to[2], length * FEED).unwrap();
    }
    text
}

/// A wall of 20 mm along x, one bead wide.
fn wall(layers: i32) -> Vec<[[f64; 3]; 2]> {
    (1..=layers).map(|k| f64::from(k) * HEIGHT).map(|z| [[0.0, 0.0, z], [20.0, 0.0, z]]).collect()
}

fn of_text(name: &str, text: &str, words: &[&str]) -> (Map<String, Value>, bool) {
    let path = input(&format!("{name}.gcode"), text);
    let (_, summary, passes) = run(&format!("beads-{name}"), &[&[path.as_str()], words].concat());
    (summary, passes)
}

fn mm(summary: &Map<String, Value>, check: &str) -> f64 {
    count_of(summary, &format!("{check}_mm"))
}

#[test]
fn a_wall_has_no_fault() {
    let (summary, passes) = of_text("wall", &gcode(&wall(6)), &[]);
    for check in ["unsupported", "in_air", "gouged", "laid_twice"] {
        assert_eq!(mm(&summary, check), 0.0, "{check}");
    }
    assert!(passes);
    let figures = ["beads", "layers", "starts", "sharp_turns"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(figures, [6, 6, 6, 0]);
    let near = |key: &str, wanted: f64| {
        assert!((summary[key].as_f64().unwrap() - wanted).abs() < 1e-3 * wanted, "{key}: {}", summary[key])
    };
    near("bead_length_mm", 120.0);
    near("height_mm", HEIGHT);
    near("bead_volume_mm3", 120.0 * FEED * std::f64::consts::PI * 0.875 * 0.875);
    assert_eq!(summary["absent"], "shadowed,uncovered,outside");
    // The page on formats has it all.
    common::assert_has_keys(&(common::formats(Some("audit.md")) + &common::summary_keys()), &summary);
}

#[test]
fn faults_have_their_lengths() {
    // 10 mm beyond the end of the wall; the wall below it is 0.5 mm lower, held to within 1.5 heights: sqrt(0.75^2 - 0.5^2) beyond, and the core of 0.25.
    let over = [[0.0, 0.0, 2.0], [30.0, 0.0, 2.0]];
    let (summary, passes) = of_text("over", &gcode(&[&wall(3)[..], &[over]].concat()), &[]);
    let held = (0.75f64.powi(2) - 0.25).sqrt();
    assert!((mm(&summary, "unsupported") - (10.0 - held)).abs() < 0.3, "{}", mm(&summary, "unsupported"));
    // The plate is within two widths of its middle.
    assert!(!passes && mm(&summary, "in_air") == 0.0);
    // Far above: all of it.
    let (summary, _) = of_text("air", &gcode(&[&wall(3)[..], &[[[0.0, 0.0, 9.0], [20.0, 0.0, 9.0]]]].concat()), &[]);
    assert!((mm(&summary, "unsupported") - 20.0).abs() < 1e-6 && (mm(&summary, "in_air") - 20.0).abs() < 1e-6);
    // Half of the second layer again.
    let (summary, passes) =
        of_text("twice", &gcode(&[&wall(3)[..], &[[[0.0, 0.0, 1.0], [10.0, 0.0, 1.0]]]].concat()), &[]);
    assert!((mm(&summary, "laid_twice") - 10.0).abs() < 0.6 && !passes, "{}", mm(&summary, "laid_twice"));
    // Beside a wall of 5 mm, 2 mm away: the cone is in it.
    let (summary, passes) =
        of_text("beside", &gcode(&[&wall(10)[..], &[[[0.0, 2.0, 0.5], [20.0, 2.0, 0.5]]]].concat()), &[]);
    assert!((mm(&summary, "gouged") - 20.0).abs() < 1e-6 && !passes, "{}", mm(&summary, "gouged"));
    let (summary, _) = of_text(
        "slender",
        &gcode(&[&wall(10)[..], &[[[0.0, 2.0, 0.5], [20.0, 2.0, 0.5]]]].concat()),
        &["--nozzle", "0.4,1,8,1"],
    );
    assert_eq!(mm(&summary, "gouged"), 0.0);
    // Through the plate.
    let (summary, _) = of_text("plate", "G0 X0 Y0 Z-1 F600\nG1 X20 E1 ;TYPE:Perimeter\n", &["--layer-height", "0.5"]);
    assert!((mm(&summary, "gouged") - 20.0).abs() < 1e-6);
}

/// Bugs: sparse support of a slicer was said to lie on nothing, and a skirt that is farther out on one side moved the part with `--centre`.
#[test]
fn support_and_skirts_are_not_of_the_part() {
    let [from, to] = [[0.0, 5.0, 4.0], [20.0, 5.0, 4.0]];
    let loose = gcode(&[&wall(4)[..], &[[from, to]]].concat());
    let (at, bead) = (loose.rfind("G0 ").unwrap(), "support");
    let of_kind = |kind: &str| format!("{};TYPE:{kind}\n{}", &loose[..at], &loose[at..]);
    for (kind, found) in [("Perimeter", 20.0), ("Support material", 0.0), ("SUPPORT-INTERFACE", 0.0)] {
        let (summary, _) = of_text(bead, &of_kind(kind), &[]);
        assert!((mm(&summary, "unsupported") - found).abs() < 1e-6, "{kind}: {}", mm(&summary, "unsupported"));
    }
    let mesh = input("wall.obj", &common::boxes_as_obj(&[[[0; 3], [20, 1, 2]]]));
    let skirt = format!(";TYPE:Skirt/Brim\n{};TYPE:Perimeter\n", gcode(&[[[40.0, 9.0, 0.5], [50.0, 9.0, 0.5]]]));
    let (summary, _) = of_text("skirt", &(skirt + &gcode(&wall(4))), &["--mesh", &mesh, "--centre"]);
    assert!(mm(&summary, "outside") == 0.0 && summary["uncovered_share"].as_f64().unwrap() < 0.02, "{summary:?}");
}

#[test]
fn a_part_says_what_is_missing_and_outside() {
    let mesh = input("bar.obj", &common::boxes_as_obj(&[[[0; 3], [20, 4, 2]]]));
    // Rows of the half with y below 2, and a row far away.
    let rows = |z: f64| [0.5, 1.5].map(|y| [[0.0, y, z], [20.0, y, z]]);
    let beads: Vec<_> =
        (1..=4).flat_map(|k| rows(f64::from(k) * HEIGHT)).chain([[[0.0, 9.0, 0.5], [10.0, 9.0, 0.5]]]).collect();
    let (summary, _) = of_text("part", &gcode(&beads), &["--mesh", &mesh, "--step", "0.1", "--slack", "0"]);
    let share = |check: &str| summary[&format!("{check}_share")].as_f64().unwrap();
    assert!((share("uncovered") - 0.5).abs() < 0.03, "{}", share("uncovered"));
    assert!((share("outside") - 10.0 / 170.0).abs() < 1e-6, "{}", share("outside"));
}

/// The same beads in other words of G-code.
#[test]
fn all_dialects_say_the_same() {
    let plain = "G90\nM83\nG0 X0 Y0 Z0.5\nG1 X10 E1\nG1 X20 Y10 E2\nG0 X0 Y20\nG1 X9 E1\n";
    let texts = [
        "G90\nM82\nG92 E5\nG0 X0 Y0 Z0.5\nG1 X10 E6\nX20 Y10 E8\nG1 E6\nG0 X0 Y20\nG1 E8\nG1 X9 E9\n",
        "G91\nM83\nG92 X0 Y0 Z0\nG1 Z0.5\nG1 X10 E1\nG1 X10 Y10 E2\nG0 X-20 Y10\nG1 X9 E1\n",
        "N1 G90 (mm)\nN2 M83\nSET_FAN VALUE=1 X3\nM204 P500 T1000\nG0 X0 Y0 Z0.5*33\nG1 X10 E1\nG1 X20 Y10 E2\nG10\nG0 X0 Y20\nG11\ng1 x9 e1\n",
        "G20\nM83\nG0 X0 Y0 Z0.0196850394\nG1 X0.3937007874 E0.03937007874\nG1 X0.7874015748 Y0.3937007874 E0.0787401575\nG0 X0 Y0.7874015748\nG1 X0.3543307087 E0.03937007874\n",
        "M83\nG92 X5\nG0 X5 Y0 Z0.5\nG1 X15 E1\nG1 X25 Y10 E2\nG0 X5 Y20\nG1 X14 E1\n",
    ];
    let keys = ["beads", "starts", "layers", "bead_length_mm", "bead_volume_mm3", "filament_mm"];
    let of =
        |name: &str, text: &str| keys.map(|key| of_text(name, text, &["--allow-gouged", "1"]).0[key].as_f64().unwrap());
    let wanted = of("plain", plain);
    assert_eq!(wanted[..3], [3.0, 2.0, 1.0]);
    for (k, text) in texts.iter().enumerate() {
        // The last one is off by G92 before the place is known, which changes nothing.
        let found = of(&format!("dialect-{k}"), text);
        assert!(wanted.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-5 * a), "{k}: {wanted:?} {found:?}");
    }
    // A circle is as long as its circumference.
    let (summary, _) = of_text("circle", "M83\nG0 X10 Y0 Z0.5\nG3 X10 Y0 I-10 J0 E5\nG2 X0 Y10 R-10 E5\n", &[]);
    let length = summary["bead_length_mm"].as_f64().unwrap();
    assert!((length - 62.832 - 47.124).abs() < 0.05, "{length}");
}

/// On a machine whose controller knows the tip, the axes say where it is; turned by 90 degrees the nozzle lies.
#[test]
fn axes_of_a_machine_are_tips_and_directions() {
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/bc-table-tcp.json");
    let letters = curvlay_kinematics::machine::FiveAxis::from_json(fs::read(machine).unwrap().as_slice())
        .unwrap()
        .letters()
        .to_vec();
    let upright = format!("M83\nG0 X0 Y0 Z0.5 {}0 {}0\nG1 X20 E2\n", letters[3], letters[4]);
    let (summary, _) = of_text("axes", &upright, &["--machine", machine]);
    assert!(
        (summary["bead_length_mm"].as_f64().unwrap() - 20.0).abs() < 1e-6
            && summary["max_tilt_of_beads_deg"].as_f64().unwrap() < 1e-6
    );
    let tilted = "M83\nG0 X0 Y0 Z0.5 B30 C0\nG1 X20 E2\n";
    let (summary, _) = of_text("tilted-axes", tilted, &["--machine", machine]);
    assert!(
        (summary["max_tilt_of_beads_deg"].as_f64().unwrap() - 30.0).abs() < 1e-6,
        "{}",
        summary["max_tilt_of_beads_deg"]
    );
}

#[test]
fn waypoints_are_a_layer_with_islands() {
    let line = |k: i32| format!("{} {} 0.5 0 0 1\n", k % 10, if k < 10 { 0 } else { 30 });
    let path = input("points.txt", &(0..20).map(line).collect::<String>());
    let (_, summary, _) = run("beads-points", &[&path, "--bead", "1", "--layer-height", "0.5"]);
    assert_eq!(["starts", "beads", "layers"].map(|key| summary[key].as_u64().unwrap()), [2, 18, 1]);
    assert_eq!(summary["absent"], "shadowed,unsupported,in_air,uncovered,outside");
}

/// Directions in comments, and the nozzle of the run, in a folder of ours.
#[test]
fn a_folder_of_ours_is_its_program() {
    let folder = common::place("audit", "ours");
    fs::create_dir_all(&folder).unwrap();
    fs::write(
        folder.join("summary.json"),
        "{\"nozzle\": \"0.4,30,6,12\", \"layer_height_mm\": 0.5, \"filament_diameter_mm\": 1.75}",
    )
    .unwrap();
    fs::write(
        folder.join("toolpath.gcode"),
        "M83\nG0 X0 Y0 Z0.5 ;DIR:0 0 1\n;WIDTH:1\n;HEIGHT:0.5\nG1 X20 E2 ;DIR:0 0.6 0.8\n",
    )
    .unwrap();
    let (_, summary, _) = run("beads-ours", &[folder.to_str().unwrap()]);
    assert_eq!((summary["beads"].as_u64(), summary["nozzle"].as_str()), (Some(1), Some("0.4,30,6,12")));
    assert!((summary["max_tilt_of_beads_deg"].as_f64().unwrap() - 0.8f64.acos().to_degrees()).abs() < 1e-6);
}

#[test]
fn a_slip_of_the_unit_is_a_finding() {
    let scaled = |factor: f64| wall(4).iter().map(|bead| bead.map(|at| at.map(|x| x * factor))).collect::<Vec<_>>();
    for (name, factor, option) in [("um", 1e-3, "1000"), ("km", 1e6, "1e-6")] {
        let (summary, passes) = of_text(name, &gcode(&scaled(factor)), &[]);
        assert!(!passes && summary["findings"].to_string().contains("no sizes of a print"), "{}", summary["findings"]);
        let (summary, passes) =
            of_text(&format!("{name}-right"), &gcode(&scaled(factor)), &["--scale", option, "--bead", "1"]);
        assert!(passes && (summary["bead_length_mm"].as_f64().unwrap() - 80.0).abs() < 1e-6, "{summary:?}");
    }
    let cells = input("km.csv", "x,y,z,layer\n0.5e6,0.5e6,0.5e6,1\n1.5e6,0.5e6,0.5e6,1\n");
    let (_, summary, passes) = run("beads-km-cells", &[&cells]);
    assert!(!passes && summary["findings"].to_string().contains("no sizes of a print"));
}

#[test]
fn bad_programs_are_one_line_and_leave_nothing() {
    let bad = [
        ("nothing.gcode", "G28\nG1 X1 Y1 Z1\n", "nothing is laid"),
        ("rotary.gcode", "G0 X0 Y0 Z1\nG1 X1 B5 E1\n", "line 2: B is a rotary axis"),
        ("unknown.gcode", "M83\nG1 X1 E1\n", "line 2: a bead before the place of XYZ"),
        ("arc.gcode", "M83\nG0 X0 Y0 Z1\nG2 X5 Y5 I1 J0 E1\n", "line 3: the arc begins"),
        ("plane.gcode", "G18\n", "line 1: G18 is not read"),
        ("word.gcode", "G0 X0 Y0 Z1\nG1 X1 E\n", "line 2: column"),
        ("far.gcode", "G0 X2000000000 Y0 Z0\n", "line 1: column"),
        ("direction.gcode", "G0 X0 Y0 Z1 ;DIR:0 0\n", "line 1: `DIR:` is no direction"),
        ("binary.gcode", "GCDE\u{1}\u{0}", "binary G-code"),
        ("sizes.txt", "0 0 0 0 0 1\n1 0 0 0 0 1\n", "give --bead"),
        ("flat.txt", "0 0 0 0 0 0\n1 0 0 0 0 1\n", "line 1: the direction"),
    ];
    bad.into_iter().for_each(assert_refused);
}

/// Slow twin: how long beads along x lie in earlier ones by more than half, by fine steps over all pairs.
fn twice_by_hand(beads: &[[[f64; 3]; 2]]) -> f64 {
    const STEP: f64 = 0.01;
    let mut sum = 0.0;
    for (k, [from, to]) in beads.iter().enumerate() {
        let steps = ((to[0] - from[0]) / STEP).round() as i32;
        for at in 0..steps {
            let x = from[0] + (f64::from(at) + 0.5) * STEP;
            let share = beads[..k].iter().map(|[a, b]| {
                let beyond = (a[0] - x).max(x - b[0]).max(0.0);
                let aside = beyond.hypot(a[1] - from[1]);
                (1.0 - aside / WIDTH).max(0.0) * (1.0 - (a[2] - from[2]).abs() / HEIGHT).max(0.0)
            });
            sum += if share.fold(0.0, f64::max) > 0.5 { STEP } else { 0.0 };
        }
    }
    sum
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn random_beads_are_laid_twice_as_by_hand(
        rows in prop::collection::vec((0_i32..20, 2_i32..12, 0_i32..6, 1_i32..5), 2..14),
    ) {
        let bead = |(x, length, y, z): &(i32, i32, i32, i32)| {
            let [x, y, z] = [f64::from(*x) * 0.5, f64::from(*y) * 0.3, f64::from(*z) * 0.3];
            [[x, y, z + 0.5], [x + f64::from(*length), y, z + 0.5]]
        };
        let beads: Vec<_> = rows.iter().map(bead).collect();
        let (summary, _) = of_text("random", &gcode(&beads), &["--bead", "1", "--layer-height", "0.5"]);
        let (found, wanted) = (mm(&summary, "laid_twice"), twice_by_hand(&beads));
        // Each end of an overlap is found to within a step of half a height.
        prop_assert!((found - wanted).abs() <= 0.25 * beads.len() as f64, "{found} {wanted}");
    }

    #[test]
    fn no_text_makes_it_panic(text in "[GMXYZEF0-9. ;()\\-\n*%TYPE:LAYER]{0,300}") {
        let path = input("any.gcode", &text);
        let folder = common::folder("audit", "beads-any");
        let args = <super::Args as clap::Parser>::try_parse_from(["audit", &path]).unwrap();
        let _ = super::example::work(&args, &curvlay_examples::bars::Bars::new(true), &folder);
    }
}
