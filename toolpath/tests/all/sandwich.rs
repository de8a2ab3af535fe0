//! Layers of thermoplastic and tape in turn: the schedule, and the moves of a machine file.

use crate::gcode_common::{BARE, read, written};
use curvlay_toolpath::deposit::{DepositionOptions, deposit};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead, TapeHeadError, with_tapes};
use curvlay_toolpath::fiber::sandwich::{SandwichError, SandwichOptions, raise, sandwich, sandwich_on};
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::gcode::{FiberCommand, Mark, Move, Tool, marked_moves};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;

fn options(base: u32, every: u32, cover: u32) -> SandwichOptions {
    SandwichOptions { base, every, cover, offset: 0.08 }
}

/// Which layers carry tape, found by walking up.
fn slow(layers: u32, options: &SandwichOptions) -> Vec<bool> {
    let mut carries = vec![false; layers as usize];
    let mut at = i64::from(options.base) - 1;
    while at < i64::from(layers) - i64::from(options.cover) {
        carries[at as usize] = true;
        at += i64::from(options.every);
    }
    carries
}

#[test]
fn schedules_that_cannot_be() {
    for (option, bad) in [("base", options(0, 1, 1)), ("every", options(1, 0, 1)), ("cover", options(1, 1, 0))] {
        assert_eq!(sandwich(5, &bad), Err(SandwichError::Zero { option }));
    }
    for offset in [-0.1, 10.1, f64::NAN] {
        let error = sandwich(5, &SandwichOptions { offset, ..SandwichOptions::default() }).unwrap_err();
        assert!(error.to_string().contains("from 0 to 10 mm"), "{error}");
    }
    for layers in [0, 1, 4] {
        let error = sandwich(layers, &options(2, 1, 3)).unwrap_err();
        assert_eq!(error, SandwichError::TooFew { layers, base: 2, cover: 3 });
    }
    assert!(sandwich(5, &options(2, 1, 3)).is_ok_and(|list| list[1].carries_tape));
    assert!(sandwich(u32::MAX, &options(u32::MAX, 1, u32::MAX)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn schedules_agree_with_the_slow_one(layers in 0u32..60, base in 1u32..8, every in 1u32..8, cover in 1u32..8) {
        let options = options(base, every, cover);
        match sandwich(layers, &options) {
            Err(error) => {
                prop_assert_eq!(error, SandwichError::TooFew { layers, base, cover });
                prop_assert!(!slow(layers, &options).contains(&true));
            }
            Ok(list) => {
                let carries: Vec<bool> = list.iter().map(|layer| layer.carries_tape).collect();
                prop_assert_eq!(&carries, &slow(layers, &options));
                for (k, layer) in list.iter().enumerate() {
                    let below = carries[..k].iter().filter(|&&has| has).count() as f64;
                    prop_assert!((layer.raised - 0.08 * below).abs() < 1e-12);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Layers that are chosen one by one: those of the other schedule give the same, whatever their order.
    #[test]
    fn chosen_layers_are_the_schedule(layers in 2u32..40, base in 1u32..8, every in 1u32..8, turn in 0usize..40) {
        let options = options(base, every, 1);
        prop_assume!(sandwich(layers, &options).is_ok());
        let wanted = sandwich(layers, &options).unwrap();
        let mut chosen: Vec<u32> = (0..layers).filter(|&layer| wanted[layer as usize].carries_tape).collect();
        chosen.push(chosen[0]);
        let by = turn % chosen.len();
        chosen.rotate_left(by);
        prop_assert_eq!(sandwich_on(layers, &chosen, options.offset).unwrap(), wanted);
    }
}

#[test]
fn layers_that_cannot_carry_tapes() {
    for (layer, layers) in [(4, 5), (5, 5), (u32::MAX, 5), (0, 1), (0, 0)] {
        assert_eq!(
            sandwich_on(layers, &[0, layer].map(|k| if layers < 2 { layer } else { k }), 0.0),
            Err(SandwichError::NoSuchLayer { layer, layers })
        );
    }
    let error = sandwich_on(5, &[11], 0.0).unwrap_err();
    assert_eq!(error.to_string(), "tapes on layer 12 of 5: it must be from 1 to 4, so that a layer covers them");
    assert!(matches!(sandwich_on(5, &[1], f64::NAN), Err(SandwichError::Offset { .. })));
    assert!(sandwich_on(5, &[], 0.0).unwrap().iter().all(|layer| !layer.carries_tape));
}

fn lean() -> UnitVector3<f64> {
    UnitVector3::new_normalize(Vector3::new(0.0, 0.6, 0.8))
}

fn tape(points: &[[f64; 3]], normal: UnitVector3<f64>) -> Tape {
    let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
    Tape { normals: vec![normal; points.len()], points, width: 5.0, thickness: 0.08 }
}

fn layer(layer: u32, tapes: Vec<Tape>) -> LayerTapes {
    LayerTapes { layer, tool: Tool::Roller, lift: 0.3, tapes }
}

/// What one sees who follows the moves with a ruler: each tape as it is laid, and how long it is from its cut on.
fn laid(moves: &[Move]) -> Vec<(Vec<Point3<f64>>, f64)> {
    let (mut at, mut tapes, mut behind, mut is_cut) = (Point3::origin(), Vec::new(), 0.0, false);
    let mut tape: Vec<Point3<f64>> = Vec::new();
    for step in moves {
        match step {
            Move::Travel { tip, .. } => at = *tip,
            Move::Fiber(FiberCommand::Press { newtons }) if *newtons > 0.0 => {
                (tape, behind, is_cut) = (vec![at], 0.0, false);
            }
            Move::Fiber(FiberCommand::Press { .. }) => tapes.push((std::mem::take(&mut tape), behind)),
            Move::Fiber(FiberCommand::Cut) => {
                assert!(!is_cut);
                is_cut = true;
            }
            Move::Lay { tip, .. } => {
                behind += if is_cut { (tip - at).norm() } else { 0.0 };
                at = *tip;
                tape.push(at);
            }
            _ => {}
        }
    }
    tapes
}

#[test]
fn tapes_lie_on_the_layer_and_are_cut_before_their_end() {
    let head = TapeHead { blade: 15.0, ..TapeHead::default() };
    let straight = [[0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [25.0, 0.0, 1.0], [40.0, 0.0, 1.0]];
    let shortest = [[0.0, 5.0, 1.0], [15.0, 5.0, 1.0]];
    let tapes = vec![tape(&straight, lean()), tape(&shortest, lean())];
    let moves = head.moves(&layer(0, tapes.clone())).unwrap();
    let seen = laid(&moves);
    assert_eq!(seen.len(), 2);
    for (tape, (way, behind)) in tapes.iter().zip(&seen) {
        assert!((behind - 15.0).abs() < 1e-12, "{behind}");
        let up = lean().into_inner() * 0.38;
        assert!((way[0] - (tape.points[0] + up)).norm() < 1e-12);
        assert!((way[way.len() - 1] - (tape.points[tape.points.len() - 1] + up)).norm() < 1e-12);
    }
    // The cut falls on a point: no move of no length. Of the shortest tape it comes at its very start.
    assert_eq!(seen.iter().map(|(way, _)| way.len()).collect::<Vec<_>>(), [4, 2]);
    for step in &moves {
        if let Move::Lay { direction, .. } = step {
            assert!((direction.into_inner() - lean().into_inner()).norm() < 1e-12);
        }
    }
    // A cold roller is not heated; no tape, no change of the tool.
    let cold = TapeHead { celsius: 0.0, ..head };
    let is_heat = |step: &Move| matches!(step, Move::Fiber(FiberCommand::Heat { .. }));
    assert_eq!(moves.iter().filter(|step| is_heat(step)).count(), 2);
    assert!(!cold.moves(&layer(0, tapes)).unwrap().iter().any(is_heat));
    assert_eq!(head.moves(&layer(0, Vec::new())), Ok(Vec::new()));
}

#[test]
fn tapes_that_cannot_be_laid() {
    let good = || tape(&[[0.0; 3], [40.0, 0.0, 0.0]], Vector3::z_axis());
    let head = TapeHead::default();
    let bad = [
        Tape { points: good().points[..1].to_vec(), ..good() },
        Tape { normals: good().normals[..1].to_vec(), ..good() },
        Tape { points: vec![Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0)], ..good() },
        Tape { width: 0.0, ..good() },
        Tape { thickness: f64::INFINITY, ..good() },
        Tape { normals: vec![UnitVector3::new_unchecked(Vector3::zeros()); 2], ..good() },
    ];
    for tape in bad {
        assert_eq!(head.moves(&layer(3, vec![good(), tape])), Err(TapeHeadError::Tape { layer: 3, tape: 1 }));
    }
    let short = tape(&[[0.0; 3], [19.9, 0.0, 0.0]], Vector3::z_axis());
    let error = head.moves(&layer(3, vec![short])).unwrap_err();
    assert!(error.to_string().contains("19.9 mm long, but 20 mm"), "{error}");
    let nozzle = LayerTapes { tool: Tool::Nozzle, ..layer(2, vec![good()]) };
    assert_eq!(head.moves(&nozzle), Err(TapeHeadError::Tool { layer: 2 }));
    let lifted = LayerTapes { lift: f64::NAN, ..layer(2, vec![good()]) };
    assert_eq!(head.moves(&lifted), Err(TapeHeadError::Layer { layer: 2 }));
    for (option, bad) in [
        ("blade", TapeHead { blade: 0.0, ..head }),
        ("force_n", TapeHead { force_n: 0.04, ..head }),
        ("celsius", TapeHead { celsius: -1.0, ..head }),
        ("lay_feed", TapeHead { lay_feed: f64::NAN, ..head }),
        ("travel_feed", TapeHead { travel_feed: 0.0, ..head }),
        ("hop", TapeHead { hop: 0.0, ..head }),
    ] {
        let error = bad.moves(&layer(0, vec![good()])).unwrap_err();
        assert!(matches!(error, TapeHeadError::Option { option: found, .. } if found == option), "{error}");
    }
    let unordered = [layer(1, vec![good()]), layer(0, vec![good()])];
    assert_eq!(with_tapes([], &unordered, &head).err(), Some(TapeHeadError::Layer { layer: 0 }));
}

/// A plan of three layers, raised, with tapes on two of them and a conductor on the last: in a file, and back.
#[test]
fn a_sandwich_in_a_machine_file() {
    let direction = Vector3::z_axis();
    let (width, height, kind) = (1.0, 0.6, BeadKind::Solid);
    let at = |x: f64, z: f64| Waypoint {
        position: Point3::new(x, 0.0, z),
        axis: direction,
        width,
        height,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind,
    };
    let path = |layer: u32| {
        let z = 0.6 * f64::from(layer + 1);
        ToolPath { layer, curve: 0, closed: false, waypoints: vec![at(0.0, z), at(50.0, z)] }
    };
    let mut paths = [path(0), path(1), path(2)];
    let schedule = sandwich(3, &SandwichOptions { offset: 0.08, ..SandwichOptions::default() }).unwrap();
    raise(&mut paths, &schedule).unwrap();
    assert!([0.6, 1.28, 1.96].iter().zip(&paths).all(|(z, path)| (path.waypoints[0].position.z - z).abs() < 1e-12));
    let wrong = [ToolPath { layer: 3, ..path(0) }];
    assert_eq!(raise(&mut wrong.clone(), &schedule), Err(SandwichError::Layer { path: 0, layer: 3, layers: 3 }));

    let on = |z: f64| tape(&[[0.0, 0.0, z], [50.0, 0.0, z]], direction);
    let mut tapes: Vec<LayerTapes> = (0..2)
        .map(|number| LayerTapes {
            lift: schedule[number as usize].raised,
            ..layer(number, vec![on(0.6 * f64::from(number + 1))])
        })
        .collect();
    tapes.push(LayerTapes { tool: Tool::Conductor, ..layer(2, vec![on(1.8)]) });
    let plan = deposit(&paths, &DepositionOptions::default()).unwrap();
    let moves: Vec<Move> =
        with_tapes(marked_moves(&plan.moves, &paths), &tapes, &TapeHead::default()).unwrap().collect();
    // The moves of the layers are all there, in their order.
    let of_tape = |step: &&Move| matches!(step, Move::Fiber(_) | Move::Lay { .. });
    let beads: Vec<&Move> = moves.iter().filter(|step| matches!(step, Move::Print { .. })).collect();
    assert_eq!(beads.len(), 3);
    let order: String = moves
        .iter()
        .filter_map(|step| match step {
            Move::Mark(Mark::Layer { .. }) => Some('m'),
            Move::Print { .. } => Some('p'),
            Move::Fiber(FiberCommand::Tool(Tool::Roller)) => Some('R'),
            Move::Fiber(FiberCommand::Tool(Tool::Conductor)) => Some('C'),
            Move::Fiber(FiberCommand::Cut) => Some('x'),
            Move::Fiber(FiberCommand::Tool(Tool::Nozzle)) => Some('N'),
            _ => None,
        })
        .collect();
    assert_eq!(order, "mpRxNmpRxNmpCxN");
    // Behind the last bead the nozzle backs off before the tool changes.
    let change = moves.iter().rposition(|step| *step == Move::Fiber(FiberCommand::Tool(Tool::Conductor))).unwrap();
    // Straight up to 10 mm over the highest tape.
    let Move::Travel { tip, .. } = moves[change - 1] else { panic!("it stays on the bead") };
    assert!((tip - Point3::new(50.0, 0.0, 12.18)).norm() < 1e-9, "{tip}");
    let file = written(&moves, &BARE()).unwrap();
    let again = read(&file).unwrap();
    assert_eq!(again.iter().filter(of_tape).count(), moves.iter().filter(of_tape).count());
    // On top of the first layer, and of the second, which is raised by the first tape.
    let heights: Vec<f64> = laid(&again).iter().map(|(way, _)| way[0].z).collect();
    assert_eq!(heights, [0.68, 1.36, 2.18]);
}

/// Arches beside each other, a bead over each, a tape from side to side on two of them: no way between passes through an arch.
#[test]
fn the_head_goes_over_what_is_built() {
    // A half circle of 30 mm in the plane of x and z.
    let at = |angle: f64, r: f64| Point3::new(-r * angle.cos(), 0.0, r * angle.sin());
    let out = |angle: f64| UnitVector3::new_normalize(at(angle, 1.0).coords);
    let angles: Vec<f64> = (0..=40).map(|k| 0.3 + 0.0635 * f64::from(k)).collect();
    let bead = |r: f64| {
        let start = Move::Travel { tip: at(angles[0], r + 2.0), direction: out(angles[0]), feed_mm_s: 80.0 };
        let lay =
            |angle: &f64| Move::Print { tip: at(*angle, r), direction: out(*angle), filament_mm: 0.1, feed_mm_s: 20.0 };
        let last = angles[angles.len() - 1];
        let end = Move::Travel { tip: at(last, r + 2.0), direction: out(last), feed_mm_s: 80.0 };
        [start].into_iter().chain(angles.iter().map(lay)).chain([end]).collect::<Vec<_>>()
    };
    let mark = |number: u32| Move::Mark(Mark::Layer { number, z_mm: 30.0, height_mm: 0.6 });
    let arch = |r: f64| Tape {
        points: angles.iter().map(|angle| at(*angle, r)).collect(),
        normals: angles.iter().map(|angle| out(*angle)).collect(),
        width: 5.0,
        thickness: 0.08,
    };
    let tapes = [LayerTapes { lift: 0.0, ..layer(0, vec![arch(30.0), arch(30.0)]) }];
    let moves = [vec![mark(0)], bead(30.0), vec![mark(1)], bead(30.6)].concat();
    let all: Vec<Move> = with_tapes(moves, &tapes, &TapeHead::default()).unwrap().collect();
    let mut from: Option<Point3<f64>> = None;
    for step in &all {
        let (Move::Travel { tip, .. } | Move::Print { tip, .. } | Move::Lay { tip, .. }) = step else { continue };
        if let (Some(from), Move::Travel { .. }) = (from, step) {
            for k in 0..=100 {
                let p = from + (tip - from) * (f64::from(k) / 100.0);
                // Between the ends of the arch nothing is below its beads.
                let is_beside = p.z < 30.0 * angles[0].sin();
                assert!(is_beside || p.coords.norm() > 29.99, "{from} {tip}");
            }
        }
        from = Some(*tip);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever the tape: what is behind the cut is what lies between blade and roller, and the way is that of the tape.
    #[test]
    fn the_cut_is_where_the_blade_is(
        steps in prop::collection::vec((0.01..30.0f64, -1.0..1.0f64), 1..12),
        blade in 1.0..60.0f64,
    ) {
        let mut at = Point3::origin();
        let mut points = vec![[0.0; 3]];
        for (length, turn) in steps {
            at += Vector3::new(turn.cos(), turn.sin(), 0.0) * length;
            points.push([at.x, at.y, 0.0]);
        }
        let tape = tape(&points, Vector3::z_axis());
        let length = tape.length();
        let head = TapeHead { blade, ..TapeHead::default() };
        match head.moves(&layer(0, vec![tape])) {
            Err(error) => {
                let is_short = matches!(error, TapeHeadError::Short { .. });
                prop_assert!(length < blade && is_short);
            }
            Ok(moves) => {
                let (way, behind) = &laid(&moves)[0];
                prop_assert!((behind - blade).abs() < 1e-9, "{} {}", behind, blade);
                let walked: f64 = way.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
                prop_assert!((walked - length).abs() < 1e-9);
                prop_assert!(way.windows(2).all(|ends| (ends[1] - ends[0]).norm() > 0.0));
            }
        }
    }
}
