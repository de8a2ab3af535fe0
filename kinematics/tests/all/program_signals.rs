//! Signals of a tape head in robot programs: what is written, and what comes back.

use crate::common::files::{Files, to_rapid};
use curvlay_kinematics::print_program::*;
use curvlay_kinematics::program::*;
use proptest::prelude::*;
use std::io;

fn moved(angle: f64) -> Step {
    let goal = Goal::Joints([angle; 6]);
    Step::Move(Move { goal, table: None, speed: Speed::default(), zone: Zone::Stop })
}

fn switch(signal: HeadSignal, on: bool) -> Step {
    Step::Signal { signal, on }
}

fn rapid(steps: &[Step], options: &RapidOptions) -> Result<Files, WriteError> {
    Ok(to_rapid(steps.iter().copied(), options)?.0)
}

fn script(steps: &[Step], options: &UrScriptOptions) -> Result<String, WriteError> {
    let mut out = Vec::new();
    write_urscript(steps.iter().copied(), options, &mut out)?;
    Ok(String::from_utf8(out).unwrap())
}

/// A tape, laid and cut.
fn tape() -> Vec<Step> {
    use HeadSignal::{Cut, Feed, Heat, Press, Roller};
    vec![
        moved(0.0),
        switch(Roller, true),
        Step::Wait(HeadInput::ToolReady),
        switch(Heat, true),
        Step::Wait(HeadInput::Hot),
        switch(Feed, true),
        switch(Feed, false),
        switch(Press, true),
        moved(0.1),
        switch(Cut, true),
        moved(0.2),
        switch(Cut, false),
        switch(Press, false),
    ]
}

#[test]
fn rapid_has_the_names() {
    let files = rapid(&tape(), &RapidOptions::default()).unwrap();
    let part = String::from_utf8(files["curvlay_001.mod"].clone()).unwrap();
    let signals: Vec<&str> = part.lines().map(str::trim).filter(|line| line.starts_with("SetDO")).collect();
    let expected = [
        "SetDO doRoller,1;",
        "SetDO doTapeHeat,1;",
        "SetDO doTapeFeed,1;",
        "SetDO doTapeFeed,0;",
        "SetDO doTapePress,1;",
        "SetDO doTapeCut,1;",
        "SetDO doTapeCut,0;",
        "SetDO doTapePress,0;",
    ];
    assert_eq!(signals, expected);
    // The main switches off what the program uses, and nothing else.
    let main = String::from_utf8(files["curvlay.mod"].clone()).unwrap();
    let off = main.split("PROC curvlay_off()").nth(1).unwrap();
    for (name, is_used) in [("doRoller", true), ("doTapeHeat", true), ("doTapeCut", true), ("doConductor", false)] {
        assert_eq!(off.contains(&format!("SetDO {name},0;")), is_used, "{off}");
    }
    assert!(!off.contains("doExtruder"));
    // `Set` and `Reset`, in any case, are read as well; the extruder keeps its own.
    let text = "MODULE m\nPROC main()\nset DOTAPECUT;\nReset doTapeCut;\nSet doPump;\nMoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let steps: Vec<Step> = read_rapid(text.as_bytes(), |_| Ok::<&[u8], _>(b"")).unwrap().map(Result::unwrap).collect();
    let cut = |on| switch(HeadSignal::Cut, on);
    assert_eq!(steps[..3], [cut(true), cut(false), Step::Extruder(true)]);
    // A name of ours for the extruder would be two signals in one.
    let options = RapidOptions { signal: "dotapecut".to_owned(), ..RapidOptions::default() };
    assert!(matches!(rapid(&tape(), &options), Err(WriteError::Name { .. })));
}

/// A module does not end while the roller presses: it would wait on the hot tape until the next is loaded.
#[test]
fn modules_end_off_the_tape() {
    let mut steps = vec![moved(0.0), switch(HeadSignal::Press, true)];
    steps.extend((1..12).map(|k| moved(f64::from(k) * 0.01)));
    steps.push(switch(HeadSignal::Press, false));
    steps.extend((0..8).map(|k| moved(f64::from(k) * 0.01)));
    let files = rapid(&steps, &RapidOptions { moves_per_module: 14, ..RapidOptions::default() }).unwrap();
    let first = String::from_utf8(files["curvlay_001.mod"].clone()).unwrap();
    assert!(first.contains("SetDO doTapePress,0;"), "{first}");
    assert_eq!(first.matches("MoveAbsJ").count(), 13);
}

#[test]
fn urscript_has_a_variable_for_each() {
    let text = script(&tape(), &UrScriptOptions::default()).unwrap();
    let at =
        |line: &str| text.lines().position(|other| other.trim() == line).unwrap_or_else(|| panic!("{line}: {text}"));
    assert!(at("tape_cut=6") < at("set_standard_digital_out(tape_cut,True)"));
    assert_eq!(text.matches("tape_cut=").count(), 1);
    // What is on at the end goes off, the roller last.
    let end: Vec<&str> = text.lines().rev().skip(1).take(2).map(str::trim).collect();
    assert_eq!(end, ["set_standard_digital_out(roller,False)", "set_standard_digital_out(tape_heat,False)"]);
    let steps: Vec<Step> = UrScriptReader::new(text.as_bytes()).unwrap().map(Result::unwrap).collect();
    let off = [HeadSignal::Heat, HeadSignal::Roller].map(|signal| switch(signal, false));
    assert_eq!(steps, [&tape()[..], &off].concat());
    // Another wiring; outputs that are there, each for one.
    let wired = UrScriptOptions { output: 1, head_outputs: [7, 2, 3, 4, 5, 0], ..UrScriptOptions::default() };
    assert!(script(&tape(), &wired).unwrap().contains("  tape_cut=0\n"));
    let twice = UrScriptOptions { head_outputs: [1, 2, 3, 4, 5, 5], ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &twice), Err(WriteError::Conflict { what: "head_outputs", .. })));
    let taken = UrScriptOptions { output: 3, ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &taken), Err(WriteError::Conflict { what: "head_outputs", .. })));
    let beyond = UrScriptOptions { head_outputs: [1, 2, 3, 4, 5, 8], ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &beyond), Err(WriteError::Option { what: "head_outputs", .. })));
    let named = UrScriptOptions { name: "tape_cut".to_owned(), ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &named), Err(WriteError::Name { .. })));
}

#[test]
fn programs_wait_for_the_head() {
    let text = script(&tape(), &UrScriptOptions::default()).unwrap();
    let ready =
        text.find("  tool_ready=1\n  while (not get_standard_digital_in(tool_ready)):\n    sync()\n  end\n").unwrap();
    let hot = text.find("  tape_hot=2\n  while (not get_standard_digital_in(tape_hot)):\n    sync()\n  end\n").unwrap();
    assert!(text.find("(roller,True)").unwrap() < ready && text.find("(tape_heat,True)").unwrap() < hot);
    let files = rapid(&tape(), &RapidOptions::default()).unwrap();
    let part = String::from_utf8(files["curvlay_001.mod"].clone()).unwrap();
    assert!(part.contains("SetDO doTapeHeat,1;\n    WaitDI diTapeHot,1;\n"), "{part}");
    // A stream stops before it waits.
    let servo = |angle: f64| Step::Servo { joints: [angle; 6], seconds: 0.008 };
    let steps = [servo(0.0), Step::Wait(HeadInput::Hot), servo(0.0)];
    let text = script(&steps, &UrScriptOptions::default()).unwrap();
    assert!(text.find("stopj").unwrap() < text.find("while").unwrap());
    // Inputs of another wiring; each its own, and one that is there.
    let wired = UrScriptOptions { head_inputs: [7, 0, 1], ..UrScriptOptions::default() };
    assert!(script(&tape(), &wired).unwrap().contains("  tape_hot=0\n"));
    let twice = UrScriptOptions { head_inputs: [3, 1, 3], ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &twice), Err(WriteError::Conflict { what: "head_inputs", .. })));
    let beyond = UrScriptOptions { head_inputs: [8, 0, 1], ..UrScriptOptions::default() };
    assert!(matches!(script(&tape(), &beyond), Err(WriteError::Option { what: "head_inputs", .. })));
    let Step::Move(to) = moved(0.1) else { unreachable!() };
    let flying = [Step::Move(Move { zone: Zone::Blend(5.0), ..to }), Step::Wait(HeadInput::Hot)];
    assert!(matches!(script(&flying, &UrScriptOptions::default()), Err(WriteError::SignalInFlight { index: 1 })));
    let bad = "def x():\n  work=p[0,0,0,0,0,0]\n  set_tcp(p[0,0,0,0,0,0])\n  while (not get_standard_digital_in(door)):\n    sync()\n  end\nend\n";
    let error = UrScriptReader::new(bad.as_bytes()).unwrap().next().unwrap().unwrap_err();
    assert!(error.to_string().contains("tool_ready, tape_hot or tape_fed"), "{error}");
}

#[test]
fn a_signal_waits_for_a_stop() {
    let Step::Move(to) = moved(0.1) else { unreachable!() };
    let flying = Step::Move(Move { zone: Zone::Blend(5.0), ..to });
    let steps = [flying, switch(HeadSignal::Cut, true), moved(0.2)];
    let error = script(&steps, &UrScriptOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::SignalInFlight { index: 1 }), "{error}");
    let messages: Vec<_> = link::LinkTranslator::new([switch(HeadSignal::Cut, true)].into_iter(), 0).collect();
    assert!(messages[0].is_err());
}

fn any_signal() -> impl Strategy<Value = HeadSignal> {
    prop::sample::select(HeadSignal::ALL.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// All three formats bring the same steps back; URScript and RAPID switch off behind them what is on.
    #[test]
    fn signals_come_back(list in prop::collection::vec((any_signal(), any::<bool>(), -3.0..3.0f64, 0..4u8), 1..20)) {
        let mut steps = vec![moved(0.0)];
        for (signal, on, angle, kind) in list {
            let wait = HeadInput::ALL[usize::from(on)];
            steps.push([Step::Extruder(on), Step::Wait(wait), switch(signal, on), switch(signal, !on)][usize::from(kind)]);
            steps.push(moved((angle * 1e3).round() / 1e3));
        }
        let mut csv = Vec::new();
        write_csv(steps.iter().copied(), &ProgramLimits::default(), &mut csv).unwrap();
        let again: Vec<Step> = CsvReader::new(csv.as_slice()).unwrap().map(Result::unwrap).collect();
        prop_assert_eq!(&again, &steps);
        let signals = |steps: &[Step]| -> Vec<Step> {
            steps.iter().copied().filter(|step| !matches!(step, Step::Move(_))).collect()
        };
        let text = script(&steps, &UrScriptOptions::default()).unwrap();
        let again: Vec<Step> = UrScriptReader::new(text.as_bytes()).unwrap().map(Result::unwrap).collect();
        prop_assert_eq!(&signals(&again)[..signals(&steps).len()], &signals(&steps)[..]);
        let files = rapid(&steps, &RapidOptions { moves_per_module: 3, ..RapidOptions::default() }).unwrap();
        let open = |name: &str| Ok::<&[u8], io::Error>(files[name].as_slice());
        let again: Vec<Step> = read_rapid(files["curvlay.mod"].as_slice(), open).unwrap().map(Result::unwrap).collect();
        let (ours, theirs) = (signals(&steps), signals(&again));
        let off = (theirs.len() - ours.len()) / 2;
        prop_assert_eq!(&theirs[off..theirs.len() - off], &ours[..]);
        let is_off = |step: &Step| matches!(step, Step::Signal { on: false, .. } | Step::Extruder(false));
        prop_assert!(theirs[..off].iter().chain(&theirs[theirs.len() - off..]).all(is_off));
        // Whatever the format, in the end all is off.
        for list in [signals(&UrScriptReader::new(text.as_bytes()).unwrap().map(Result::unwrap).collect::<Vec<_>>()), theirs] {
            for signal in HeadSignal::ALL {
                let last = list.iter().rev().find_map(|step| match step {
                    Step::Signal { signal: other, on } if *other == signal => Some(*on),
                    _ => None,
                });
                prop_assert_ne!(last, Some(true));
            }
        }
    }

    /// Signals of a leg come before the first tick at or after their time; those beyond the last tick at the end of the leg.
    #[test]
    fn a_stream_switches_in_time(
        durations in prop::collection::vec(0.001..0.2f64, 1..5),
        times in prop::collection::vec((0usize..5, 0.0..=1.0f64, any_signal()), 0..10),
    ) {
        let leg = |(k, &duration_s): (usize, &f64)| {
            let mut signals: Vec<TimedSignal> = times
                .iter()
                .filter(|(leg, ..)| leg % durations.len() == k)
                .map(|&(_, share, signal)| TimedSignal { time_s: share * duration_s, signal, on: true })
                .collect();
            signals.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            StreamSegment { duration_s, joints: |_: f64| [0.0; 6], filament_mm: None::<fn(f64) -> f64>, signals }
        };
        let steps: Vec<Step> =
            print_stream([[0.0; 6]; 2], durations.iter().enumerate().map(leg), StreamOptions::default()).collect();
        let period = ServoRate::Hz125.seconds();
        // When each signal is due on the clock of the whole print, and in which tick it comes.
        let mut due: Vec<f64> = Vec::new();
        let mut begin = 0.0;
        for (k, duration) in durations.iter().enumerate() {
            due.extend(times.iter().filter(|(leg, ..)| leg % durations.len() == k).map(|(_, share, _)| begin + share * duration));
            begin += duration;
        }
        due.sort_by(f64::total_cmp);
        let (mut tick, mut came) = (0u32, Vec::new());
        for step in &steps[1..] {
            match step {
                Step::Servo { .. } => tick += 1,
                _ => came.push(f64::from(tick + 1) * period),
            }
        }
        prop_assert_eq!(came.len(), due.len());
        for (came, due) in came.iter().zip(&due) {
            prop_assert!(came - due > -1e-9 && came - due < period + 1e-9, "{} {}", came, due);
        }
    }
}

/// A motion of a tape head as targets: no extruder, signals where the arm stops, the cut at its own knot.
#[cfg(feature = "serde")] // the cell is read from a file of the examples
#[test]
fn a_tape_is_laid_by_targets() {
    use curvlay_kinematics::workcell::AnyWorkcell;
    let file = include_str!("../../../examples/cells/ur3.json");
    let AnyWorkcell::Six(cell) = AnyWorkcell::from_json(file.as_bytes()).unwrap() else { panic!("it has a table") };
    let knot = |k: u32| PrintKnot {
        time_s: 3.0 + f64::from(k),
        joints: [0.02 * f64::from(k), -1.0, -1.5, 0.3, 0.2, 0.0],
        filament_mm: 0.0,
    };
    let at = |time_s: f64, signal: HeadSignal, on: bool| TimedSignal { time_s, signal, on };
    let signals = vec![
        at(0.0, HeadSignal::Press, true),
        at(2.0, HeadSignal::Cut, true),
        at(4.0, HeadSignal::Cut, false),
        at(4.0, HeadSignal::Press, false),
    ];
    let motion = TargetMotion { knots: (0..5).map(knot).collect(), onward: vec![[0.0; 6]], head: Some(signals) };
    let steps: Vec<Step> =
        print_targets(&cell, [motion], TargetOptions { merge_mm: 1.0, ..TargetOptions::default() }).collect();
    let kinds: String = steps
        .iter()
        .map(|step| match step {
            Step::Move(Move { goal: Goal::Joints(_), .. }) => 'j',
            Step::Move(Move { zone: Zone::Stop, .. }) => 's',
            Step::Move(_) => 'b',
            Step::Signal { signal: HeadSignal::Press, .. } => 'P',
            Step::Signal { signal: HeadSignal::Cut, .. } => 'C',
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(kinds, "jPbsCbsCPj");
    assert!(rapid(&steps, &RapidOptions::default()).is_ok());
    // Signals behind the end come at it; without knots there are none.
    let late = TargetMotion {
        knots: (0..2).map(knot).collect(),
        head: Some(vec![at(9.0, HeadSignal::Cut, true)]),
        ..Default::default()
    };
    let steps: Vec<Step> = print_targets(
        &cell,
        [late, TargetMotion { head: Some(Vec::new()), ..Default::default() }],
        TargetOptions::default(),
    )
    .collect();
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[2], switch(HeadSignal::Cut, true));
}
