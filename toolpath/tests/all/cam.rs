//! APT and CSV, judged by parsers that share nothing with the writers.

use crate::gcode_common::{travel, unit};
use curvlay_toolpath::cam::*;
use curvlay_toolpath::gcode::{FiberCommand, Mark, Move, Tool};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;

fn print(tip: [f64; 3], direction: UnitVector3<f64>, filament_mm: f64, feed_mm_s: f64) -> Move {
    Move::Print { tip: tip.into(), direction, filament_mm, feed_mm_s }
}

fn a_few() -> Vec<Move> {
    let (up, lean) = (Vector3::z_axis(), unit(0.0, 0.6, 0.8));
    vec![
        Move::Nozzle { celsius: 210.0, wait: true },
        Move::Home,
        Move::Mark(Mark::Layer { number: 0, z_mm: 0.3, height_mm: 0.3 }),
        travel([1.0, -2.0, 0.3], up, 80.0),
        Move::Mark(Mark::Bead { kind: BeadKind::Wall, width_mm: 0.5, height_mm: 0.3 }),
        print([11.0, -2.0, 0.3], up, 0.62, 20.0),
        print([11.0, 8.0, 0.31], lean, 0.62, 20.0),
        Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 },
        travel([0.0, 0.0, 5.0], lean, 80.0),
        Move::Prime { filament_mm: 1.0, feed_mm_s: 20.0 },
        Move::Dwell { seconds: 0.25 },
        Move::Mark(Mark::Bead { kind: BeadKind::Infill, width_mm: 0.45, height_mm: 0.28 }),
        print([0.0, 3.0, 1.0], up, 0.2, 12.5),
    ]
}

/// A statement of APT: what it begins with, and what stands behind the `/`.
fn statements(file: &str) -> Vec<(String, Vec<String>)> {
    file.lines()
        .map(|line| {
            assert!(line.len() <= 72 && line.is_ascii(), "{line}");
            let (word, rest) = line.split_once('/').unwrap_or((line, ""));
            assert!(word.chars().all(|c| c.is_ascii_uppercase()), "{line}");
            (word.to_owned(), rest.split(',').filter(|text| !text.is_empty()).map(str::to_owned).collect())
        })
        .collect()
}

/// Where the tip goes, as an APT file says: rapid or at which feed, with the extruder on or off.
#[derive(Debug, PartialEq)]
struct Went {
    to: [f64; 6],
    /// None for a rapid.
    mm_min: Option<f64>,
    is_on: bool,
}

fn went(file: &str) -> Vec<Went> {
    let (mut list, mut rapid, mut feed, mut is_on) = (Vec::new(), false, None, false);
    for (word, rest) in statements(file) {
        match word.as_str() {
            "GOTO" => {
                let to: Vec<f64> = rest.iter().map(|text| text.parse().unwrap()).collect();
                let mm_min = if rapid { None } else { feed };
                list.push(Went { to: to.try_into().unwrap(), mm_min, is_on });
                rapid = false;
            }
            "RAPID" => rapid = true,
            "FEDRAT" => {
                assert_eq!(rest[1], "MMPM");
                feed = Some(rest[0].parse().unwrap());
            }
            "AUXFUN" => is_on = rest[0] == "101",
            "PARTNO" | "UNITS" | "MULTAX" | "PPRINT" | "PAINT" | "DELAY" | "GOHOME" | "END" | "FINI" => {}
            other => panic!("{other} is no statement"),
        }
    }
    list
}

fn apt(moves: &[Move], options: &AptOptions) -> Result<String, CamError> {
    let mut file = Vec::new();
    let written = write_apt(moves.iter().copied(), options, &mut file)?;
    let file = String::from_utf8(file).unwrap();
    assert_eq!((written.moves, written.lines), (moves.len() as u64, file.lines().count() as u64));
    Ok(file)
}

#[test]
fn apt_to_the_letter() {
    let file = apt(&a_few(), &AptOptions { name: "jug, \u{fc}ber/2", ..AptOptions::default() }).unwrap();
    let expected = "PARTNO/jug_ _ber_2\nUNITS/MM\nMULTAX/ON\nGOHOME\nPPRINT/LAYER 1\nRAPID\nGOTO/1,-2,0.3,0,0,1\nPAINT/COLOR,1\n\
                    AUXFUN/101\nFEDRAT/1200,MMPM\nGOTO/11,-2,0.3,0,0,1\nGOTO/11,8,0.31,0,0.6,0.8\nAUXFUN/103\nRAPID\n\
                    GOTO/0,0,5,0,0.6,0.8\nDELAY/0.25\nPAINT/COLOR,4\nAUXFUN/101\nFEDRAT/750,MMPM\nGOTO/0,3,1,0,0,1\nAUXFUN/103\n\
                    END\nFINI\n";
    assert_eq!(file, expected);
    let silent = apt(&a_few(), &AptOptions { extruder: None, ..AptOptions::default() }).unwrap();
    assert!(!silent.contains("AUXFUN") && silent.starts_with("PARTNO/CURVLAY\n"));
    let long = "x".repeat(200);
    assert_eq!(
        apt(&a_few(), &AptOptions { name: &long, ..AptOptions::default() }).unwrap().lines().next().unwrap().len(),
        67
    );
}

/// A line of the CSV by its columns.
fn rows(file: &str) -> Vec<Vec<(String, String)>> {
    let mut lines = file.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), names.len(), "{line}");
        names.iter().zip(cells).map(|(name, cell)| ((*name).to_owned(), cell.to_owned())).collect()
    };
    lines.map(row).collect()
}

fn csv(moves: &[Move]) -> Result<String, CamError> {
    let mut file = Vec::new();
    let written = write_csv(moves.iter().copied(), &mut file)?;
    let file = String::from_utf8(file).unwrap();
    assert_eq!((written.moves, written.lines), (moves.len() as u64, file.lines().count() as u64));
    Ok(file)
}

#[test]
fn csv_to_the_letter() {
    let expected = "kind,x_mm,y_mm,z_mm,i,j,k,filament_mm,feed_mm_s,seconds,layer,bead,width_mm,height_mm\n\
                    home,,,,,,,,,,,,,\n\
                    travel,1,-2,0.3,0,0,1,,80,0,1,,,\n\
                    print,11,-2,0.3,0,0,1,0.62,20,0.5,1,wall,0.5,0.3\n";
    assert!(csv(&a_few()).unwrap().starts_with(expected), "{}", csv(&a_few()).unwrap());
    let file = csv(&a_few()).unwrap();
    let kinds: Vec<String> = rows(&file).iter().map(|row| row[0].1.clone()).collect();
    assert_eq!(kinds, ["home", "travel", "print", "print", "retract", "travel", "prime", "dwell", "print"]);
    let cell = |row: usize, name: &str| rows(&file)[row].iter().find(|cell| cell.0 == name).unwrap().1.clone();
    assert_eq!(
        (cell(4, "filament_mm"), cell(6, "filament_mm"), cell(7, "seconds")),
        ("-1".into(), "1".into(), "0.25".into())
    );
    assert_eq!(
        (cell(8, "bead"), cell(8, "width_mm"), cell(8, "height_mm")),
        ("infill".into(), "0.45".into(), "0.28".into())
    );
    assert!(rows(&file).iter().all(|row| row.len() == 14));
}

/// A tape: the roller comes, feeds, presses, rolls at its feed, cuts.
#[test]
fn tapes_to_the_letter() {
    let up = Vector3::z_axis();
    let fiber = |command| Move::Fiber(command);
    let moves = [
        fiber(FiberCommand::Tool(Tool::Roller)),
        fiber(FiberCommand::Heat { celsius: 210.0, wait: true }),
        travel([0.0, 0.0, 1.0], up, 80.0),
        fiber(FiberCommand::Feed { length_mm: 12.5 }),
        fiber(FiberCommand::Press { newtons: 20.0 }),
        Move::Lay { tip: Point3::new(30.0, 0.0, 1.0), direction: up, feed_mm_s: 10.0 },
        fiber(FiberCommand::Cut),
        fiber(FiberCommand::Tool(Tool::Nozzle)),
    ];
    let file = apt(&moves, &AptOptions::default()).unwrap();
    let lines: Vec<&str> = file.lines().skip(3).collect();
    let expected = [
        "LOADTL/2",
        "PPRINT/TAPE HEAT 210",
        "RAPID",
        "GOTO/0,0,1,0,0,1",
        "PPRINT/TAPE FEED 12.5",
        "PPRINT/TAPE PRESS 20",
        "FEDRAT/600,MMPM",
        "GOTO/30,0,1,0,0,1",
        "PPRINT/TAPE CUT",
        "LOADTL/1",
        "END",
        "FINI",
    ];
    assert_eq!(lines, expected);
    let file = csv(&moves).unwrap();
    let lines: Vec<&str> = file.lines().skip(1).collect();
    let expected = [
        "roller,,,,,,,,,,,,,",
        "travel,0,0,1,0,0,1,,80,0,,,,",
        "feed,,,,,,,12.5,,,,,,",
        "lay,30,0,1,0,0,1,,10,3,,,,",
        "cut,,,,,,,,,,,,,",
        "nozzle,,,,,,,,,,,,,",
    ];
    assert_eq!(lines, expected);
    let bad = [fiber(FiberCommand::Feed { length_mm: f64::NAN })];
    assert!(apt(&bad, &AptOptions::default()).is_err() && csv(&bad).is_err());
}

#[test]
fn what_cannot_be_is_refused() {
    let up = Vector3::z_axis();
    let bad = [
        travel([f64::NAN, 0.0, 0.0], up, 80.0),
        travel([0.0, 2e6, 0.0], up, 80.0),
        travel([0.0; 3], up, 0.0),
        travel([0.0; 3], UnitVector3::new_unchecked(Vector3::new(0.0, 0.0, 2.0)), 80.0),
        Move::Dwell { seconds: -1.0 },
    ];
    for step in bad {
        let moves = [travel([0.0; 3], up, 80.0), step];
        for error in [apt(&moves, &AptOptions::default()).unwrap_err(), csv(&moves).unwrap_err()] {
            assert!(matches!(error, CamError::Number { index: 1, .. }), "{error}");
        }
    }
    let negative = [print([0.0; 3], up, -1.0, 20.0)];
    assert!(matches!(csv(&negative), Err(CamError::Number { what: "filament_mm", .. })));
    assert!(matches!(csv(&[Move::Retract { filament_mm: 1.0, feed_mm_s: f64::NAN }]), Err(CamError::Number { .. })));
    let width = [Move::Mark(Mark::Bead { kind: BeadKind::Wall, width_mm: f64::NAN, height_mm: 0.3 })];
    assert!(matches!(csv(&width), Err(CamError::Number { what: "width_mm", .. })));
    assert!(matches!(apt(&[], &AptOptions::default()), Err(CamError::Empty)));
    assert!(matches!(csv(&[]), Err(CamError::Empty)));

    struct Full;
    impl std::io::Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    assert!(matches!(write_apt(a_few(), &AptOptions::default(), Full), Err(CamError::Io(_))));
    assert!(matches!(write_csv(a_few(), Full), Err(CamError::Io(_))));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Places, directions and feeds come back: from APT to its digits, from CSV to the last bit.
    #[test]
    fn both_say_where_the_nozzle_goes(list in prop::collection::vec(
        ((-999.0..999.0f64, -999.0..999.0f64, 0.0..999.0f64), (-1.0..1.0f64, -1.0..1.0f64), 1.0..200.0f64, any::<bool>()), 1..20,
    )) {
        let moves: Vec<Move> = list
            .iter()
            .map(|&((x, y, z), (i, j), feed, prints)| {
                let direction = unit(i, j, 1.0);
                if prints { print([x, y, z], direction, 0.1, feed) } else { travel([x, y, z], direction, feed) }
            })
            .collect();
        let (apt, csv) = (went(&apt(&moves, &AptOptions::default()).unwrap()), rows(&csv(&moves).unwrap()));
        prop_assert_eq!((apt.len(), csv.len()), (moves.len(), moves.len()));
        for ((step, apt), csv) in moves.iter().zip(&apt).zip(&csv) {
            let (Move::Travel { tip, direction, feed_mm_s } | Move::Print { tip, direction, feed_mm_s, .. }) = *step else { continue };
            let prints = matches!(step, Move::Print { .. });
            let number = |column: usize| csv[column].1.parse::<f64>().unwrap();
            prop_assert_eq!(tip, Point3::new(number(1), number(2), number(3)));
            prop_assert_eq!(direction.into_inner(), Vector3::new(number(4), number(5), number(6)));
            prop_assert_eq!(feed_mm_s.to_bits(), number(8).to_bits());
            prop_assert_eq!(&csv[0].1[..], if prints { "print" } else { "travel" });
            for k in 0..3 {
                prop_assert!((apt.to[k] - tip[k]).abs() <= 0.51e-4 && (apt.to[k + 3] - direction[k]).abs() <= 0.51e-6);
            }
            prop_assert_eq!(apt.is_on, prints);
            prop_assert_eq!(apt.mm_min.is_some(), prints);
            if let Some(feed) = apt.mm_min {
                prop_assert!((feed / 60.0 - feed_mm_s).abs() < 1e-4);
            }
        }
    }
}
