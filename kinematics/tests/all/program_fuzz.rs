//! Readers of programs and any input: no panic, no end that does not come, no number that is not finite.

use curvlay_kinematics::nalgebra::Isometry3;
use curvlay_kinematics::program::*;
use proptest::prelude::*;
use std::io;

/// Numbers of steps up to which a program is read.
const MOST: usize = 100_000;

fn is_pose(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector.iter().all(|x| x.is_finite()) && (pose.rotation.as_ref().norm() - 1.0).abs() < 1e-6
}

/// Whether all numbers of a step are finite.
fn is_finite(step: &Step) -> bool {
    match step {
        Step::Move(to) => {
            let goal = match &to.goal {
                Goal::Line(target) | Goal::JointMove(target) => is_pose(&target.pose),
                Goal::Joints(joints) => joints.iter().all(|x| x.is_finite()),
            };
            let zone = if let Zone::Blend(radius) = to.zone { radius.is_finite() && radius > 0.0 } else { true };
            let table = to.table.iter().flat_map(ExternalAxes::axes).flatten().all(f64::is_finite);
            goal && zone && table && to.speed.mm_s.is_finite() && to.speed.rad_s.is_finite()
        }
        Step::Servo { joints, seconds } => joints.iter().all(|x| x.is_finite()) && seconds.is_finite(),
        Step::Extruder(_) | Step::Signal { .. } | Step::Wait(_) => true,
        Step::FilamentSpeed(mm_s) => mm_s.is_finite(),
    }
}

fn all_finite(steps: impl Iterator<Item = Result<Step, ReadError>>) -> bool {
    steps.take(MOST).all(|step| step.as_ref().is_ok_and(is_finite) || step.is_err())
}

fn is_load(load: Option<&Payload>) -> bool {
    load.is_none_or(|load| load.mass_kg.is_finite() && load.centre.coords.iter().all(|x| x.is_finite()))
}

/// All readers on one text; false if one gives a number that is not finite.
fn reads_well(text: &[u8]) -> bool {
    let script = UrScriptReader::new(text).map(|reader| {
        is_pose(reader.work()) && is_pose(reader.tool()) && is_load(reader.payload()) && all_finite(reader)
    });
    let csv = CsvReader::new(text).map(all_finite);
    let part = RapidPart::new(text).map(all_finite);
    // The module loads itself, whatever it asks for.
    let program = read_rapid(text, |_| Ok::<_, io::Error>(text)).map(|program| {
        let main = program.main();
        let tool = main.tool.as_ref().is_none_or(|tool| is_pose(&tool.frame) && is_load(tool.load.as_ref()));
        tool && main.work_object.as_ref().is_none_or(|work| is_pose(&work.frame)) && all_finite(program)
    });
    [script.unwrap_or(true), csv.unwrap_or(true), part.unwrap_or(true), program.unwrap_or(true)]
        .iter()
        .all(|well| *well)
}

const FILES: [&str; 5] = [
    include_str!("../golden/curvlay.script"),
    include_str!("../golden/curvlay.csv"),
    include_str!("../golden/dome.mod"),
    include_str!("../golden/dome_001.mod"),
    include_str!("program_rapid/pendant.mod"),
];

/// A script with what the golden one has not.
const SCRIPT: &str = "def a():\n nozzle=p[0.1,0.2,0.3,1,2,3]\n set_tcp(p[0,0,0.1,0,0,0.5])\n set_payload(1.5,[0.1,0.2,0.3])\n \
                      filament_full_scale=20.0\n movel(pose_trans(nozzle,p[0.1,0.2,0.3,0.5,0.6,0.7]),a=1.2,v=0.1,r=0.01)\n \
                      movej([1,2,3,4,5,6],a=1,v=2,r=0)\n servoj([1,2,3,4,5,6],t=0.008,lookahead_time=0.1,gain=300)\n \
                      set_standard_analog_out(0,2.5/filament_full_scale)\n stopj(1.4)\nend\n";
const GROUP: &str =
    "MODULE a\n LOCAL CONST num filament_step:=0.5;\n PROC main()\n SetGO f,7;\n SetAO g,3;\n ENDPROC\nENDMODULE\n";

/// Triggers and accelerations.
const TRIGGERS: &str = "MODULE a\n VAR triggdata on;\n VAR triggdata fed;\n LOCAL CONST num filament_step:=0.5;\n PROC main()\n AccSet 50,60;\n \
                        PathAccLim TRUE\\AccMax:=2,TRUE\\DecelMax:=3;\n WorldAccLim\\On:=4;\n TriggIO on,0\\DOp:=d,1;\n \
                        TriggEquip fed,0\\Start,0.05\\GOp:=g,7;\n TriggL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,\
                        on\\T2:=fed,z10,tool0;\n ENDPROC\nENDMODULE\n";

/// Numbers that are no place, or only just.
const NUMBERS: [&str; 16] = [
    "1e308",
    "-1e308",
    "1.7976931348623157e308",
    "1e307",
    "1e155",
    "-1e155",
    "1e999",
    "1e-320",
    "-1e-320",
    "0",
    "-0",
    "9e9",
    "1e6",
    "-1e6",
    "1000001",
    "123456789012345678901234567890",
];

/// Every number of every file in turn: the reader of URScript gave NaN for `1e308`.
#[test]
fn no_number_gives_one_that_is_not_finite() {
    for file in FILES.into_iter().chain([SCRIPT, GROUP, TRIGGERS]) {
        assert!(reads_well(file.as_bytes()));
        let bytes = file.as_bytes();
        let mut at = 0;
        while at < bytes.len() {
            let end =
                (at..bytes.len()).find(|&k| !(bytes[k].is_ascii_digit() || bytes[k] == b'.')).unwrap_or(bytes.len());
            if end > at && (at == 0 || !bytes[at - 1].is_ascii_alphanumeric()) {
                for number in NUMBERS {
                    let text = [&file[..at], number, &file[end..]].concat();
                    assert!(reads_well(text.as_bytes()), "{text}");
                }
            }
            at = end.max(at + 1);
        }
    }
}

/// The error says where the number stands.
#[test]
fn numbers_that_are_too_large_are_named() {
    let script = |from: &str, to: &str| {
        let text = SCRIPT.replacen(from, to, 1);
        let steps = UrScriptReader::new(text.as_bytes()).and_then(Iterator::collect::<Result<Vec<Step>, _>>);
        steps.unwrap_err().to_string()
    };
    assert!(script("p[0.1,", "p[1e308,").starts_with("line 2, column 11: 1"), "{}", script("p[0.1,", "p[1e308,"));
    assert!(script("0.7]", "1e308]").ends_with("cannot be a rotation in radians"));
    assert!(script("v=0.1", "v=1e308").ends_with("cannot be a speed"));
    assert!(script("r=0.01", "r=1e308").ends_with("cannot be a radius"));
    assert!(script("[1,2,", "[1,1e307,").ends_with("cannot be a joint"));
    assert!(script("t=0.008", "t=1e7").ends_with("cannot be a time"));
    assert!(script("=20.0", "=1e300").ends_with("cannot be a speed of the filament"));
    let csv = include_str!("../golden/curvlay.csv").replacen("-12.25", "1e308", 1);
    let steps: Result<Vec<Step>, _> = CsvReader::new(csv.as_bytes()).unwrap().collect();
    assert!(steps.unwrap_err().to_string().contains("cannot be a number of a program"));
}

/// Words and marks of all three formats.
const WORDS: [&str; 60] = [
    "MODULE ",
    "a ",
    "p ",
    "PROC ",
    "main",
    "()",
    "ENDPROC ",
    "ENDMODULE ",
    "CONST ",
    "PERS ",
    "LOCAL ",
    "robtarget ",
    "num ",
    "tooldata ",
    "wobjdata ",
    "speeddata ",
    ":=",
    ";",
    ",",
    "[",
    "]",
    "[1,0,0,0]",
    "[0,0,0]",
    "[0,0,0,0]",
    "[9E9,9E9,9E9,9E9,9E9,9E9]",
    "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]",
    "MoveL ",
    "MoveJ ",
    "MoveAbsJ ",
    "v100",
    "fine",
    "z10",
    "tool0",
    "\\WObj:=",
    "\\V:=",
    "Offs(",
    ")",
    "Set ",
    "SetDO ",
    "SetAO ",
    "SetGO ",
    "Load\\Dynamic,",
    "\"HOME:\"",
    "\\File:=",
    "%",
    "\"a\"",
    "%%%",
    "ERROR ",
    "def ",
    "work=",
    "p[0,0,0,0,0,0]",
    "set_tcp(",
    "movel(",
    "servoj(",
    "end ",
    "1e308",
    "-",
    "+",
    "TRUE",
    "\n",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        prop_assert!(reads_well(&bytes));
    }

    #[test]
    fn any_words(words in prop::collection::vec(prop::sample::select(WORDS.to_vec()), 0..80), head in 0..4usize) {
        let head = ["", "MODULE a PROC main() ", "MODULE a ", "def a():\nwork=p[0,0,0,0,0,0]\nset_tcp(p[0,0,0,0,0,0])\n"][head];
        prop_assert!(reads_well([head, &words.concat()].concat().as_bytes()));
    }

    /// Files with pieces cut out, doubled, or overwritten.
    #[test]
    fn damaged_files(
        file in 0..FILES.len(), from in any::<prop::sample::Index>(), length in 0..200usize, way in 0..3u8, byte in any::<u8>(),
    ) {
        let mut bytes = FILES[file].as_bytes().to_vec();
        let from = from.index(bytes.len());
        let to = (from + length).min(bytes.len());
        match way {
            0 => drop(bytes.drain(from..to)),
            1 => { let piece = bytes[from..to].to_vec(); drop(bytes.splice(from..from, piece)); }
            _ => bytes[from..to].fill(byte),
        }
        prop_assert!(reads_well(&bytes));
    }
}

/// A file without end is an error, not a full memory.
#[test]
fn files_without_end_are_refused() {
    let endless = || io::BufReader::new(io::repeat(b'0'));
    assert!(matches!(RapidPart::new(endless()).map(|_| ()), Err(ReadError::LineTooLong { .. })));
    assert!(matches!(UrScriptReader::new(endless()).map(|_| ()), Err(ReadError::LineTooLong { .. })));
    assert!(matches!(CsvReader::new(endless()).map(|_| ()), Err(ReadError::LineTooLong { .. })));
    assert!(matches!(RapidMain::read(endless()), Err(ReadError::LineTooLong { .. })));
}

/// A mark that editors put before UTF-8, and lines that end in CR LF.
#[test]
fn marks_of_editors_are_passed_over() {
    for file in FILES {
        let edited = format!("\u{feff}{}", file.replace('\n', "\r\n"));
        let steps = |text: &str| -> Vec<Step> {
            type Read = Result<Vec<Step>, ReadError>;
            if let Ok(reader) = UrScriptReader::new(text.as_bytes()) {
                return reader.collect::<Read>().unwrap();
            }
            if let Ok(reader) = CsvReader::new(text.as_bytes()) {
                return reader.collect::<Read>().unwrap();
            }
            let part = |_: &str| Ok::<_, io::Error>(FILES[3].as_bytes());
            read_rapid(text.as_bytes(), part).unwrap().collect::<Read>().unwrap()
        };
        assert_eq!(steps(&edited), steps(file));
    }
}
