//! The envelope, the flood and the field against slow twins, on small random parts.

use super::*;
use crate::curved::{AuditReport, Fault, Strategy};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::ops::ControlFlow;

const DIMS: [u32; 3] = [5, 3, 4];

fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Cells of a small grid, one bit row each, and a time for each cell of the grid.
fn parts() -> impl proptest::strategy::Strategy<Value = (Vec<u64>, Vec<f64>)> {
    let rows = proptest::collection::vec(0u64..1 << DIMS[0], (DIMS[1] * DIMS[2]) as usize);
    let times = proptest::collection::vec(0.0f64..9.0, (DIMS[0] * DIMS[1] * DIMS[2]) as usize);
    (rows, times)
}

/// Runs `check` with the part and times of its cells. What stands is in the first step.
fn with(rows: &[u64], times: &[f64], check: impl Fn(&Envelope, Vec<f64>)) {
    let cells = Cells::new(DIMS, rows).unwrap();
    let (platform, rules) =
        (Platform::under(&cells, 4.0).unwrap(), Rules { inside_depth_cells: 0.5, ..Rules::default() });
    let part = Part::new(&cells, &rules, &supported_by_platform(&cells, &platform, &rules).unwrap());
    let time = |place: usize| if part.stands[place] { 0.5 } else { times[part.cells[place] as usize] };
    let times = (0..part.cells.len()).map(time).collect();
    check(&Envelope { part: &part, cells: &cells, platform: &platform, rules: &rules, progress: &go }, times);
}

/// The audit of the cells in these steps.
fn audited(of: &Envelope, steps: &[Vec<u32>]) -> AuditReport {
    let mut order = LayerOrder::new();
    steps.iter().filter(|step| !step.is_empty()).for_each(|step| order.push(step.iter().copied()));
    audit(of.cells, of.platform, of.rules, &order, &[], &go).unwrap()
}

fn steps_of(of: &Envelope, times: &[f64]) -> Vec<Vec<u32>> {
    let mut steps = vec![Vec::new(); 64];
    of.part.cells.iter().zip(times).for_each(|(&cell, &time)| steps[time as usize].push(cell));
    steps
}

/// Whether a cell is inside once all steps up to this one are built, as the audit has it.
fn is_inside(of: &Envelope, steps: &[Vec<u32>], step: usize, cell: u32) -> bool {
    let mut until: Vec<Vec<u32>> =
        steps[..=step].iter().map(|step| step.iter().copied().filter(|&c| c != cell).collect()).collect();
    until.push(vec![cell]);
    audited(of, &until)
        .faults
        .iter()
        .any(|fault| matches!(*fault, Fault::Inside { cell: inside, .. } if inside == cell))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(25), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_envelope_is_the_step_that_covers_a_cell((rows, times) in parts()) {
        with(&rows, &times, |of, times| {
            let steps = steps_of(of, &times);
            let shadowed = of.shadowed(&times).unwrap();
            for (&cell, &time) in of.part.cells.iter().zip(&times) {
                let covering = (0..time as usize).find(|&step| is_inside(of, &steps, step, cell));
                // Nothing is built in an empty step, so the one that covers has cells.
                let found = shadowed.iter().find(|covered| covered.cell == cell).map(|covered| covered.layer);
                assert_eq!(found, covering, "cell {cell}");
            }
        });
    }

    #[test]
    fn what_is_lowered_stays((rows, times) in parts()) {
        with(&rows, &times, |of, mut times| {
            of.lower(&mut times).unwrap();
            assert!(of.shadowed(&times).unwrap().is_empty());
            let once = times.clone();
            of.lower(&mut times).unwrap();
            assert_eq!(times, once);
        });
    }

    #[test]
    fn the_flood_is_the_least_supported_field((rows, times) in parts()) {
        with(&rows, &times, |of, times| {
            // From below, until nothing changes: a cell comes no sooner than the step after its earliest neighbour.
            let part = of.part;
            let mut slow = times.clone();
            let unreached = 200.0; // later than any: what nothing carries rises for ever
            loop {
                let next: Vec<f64> = (0..slow.len()).map(|place| {
                    let earliest = part.around(place).map(|next| slow[next].floor() + 1.0).fold(f64::INFINITY, f64::min);
                    if part.stands[place] { times[place] } else { times[place].max(earliest).min(unreached) }
                }).collect();
                if next == slow {
                    break;
                }
                slow = next;
            }
            let fast = flooded(part, &times);
            let capped: Vec<f64> = fast.iter().map(|time| time.min(unreached)).collect();
            assert_eq!(capped, slow);
            if fast.iter().all(|time| time.is_finite()) {
                assert_eq!(flooded(part, &fast), fast);
            }
        });
    }

    #[test]
    fn times_on_their_envelope_with_supports_pass_the_audit((rows, times) in parts()) {
        with(&rows, &times, |of, times| {
            let times = flooded(of.part, &times);
            if times.iter().all(|&time| time < 60.0) && of.shadowed(&times).unwrap().is_empty() {
                let report = audited(of, &steps_of(of, &times));
                assert!(report.is_ok(), "{report}");
            }
        });
    }

    #[test]
    fn a_coherent_field_passes_the_audit_and_keeps_the_cells((rows, _) in parts()) {
        let cells = Cells::new(DIMS, &rows).unwrap();
        let (platform, rules) = (Platform::under(&cells, 4.0).unwrap(), Rules { inside_depth_cells: 0.5, ..Rules::default() });
        let growth = Strategy::Incremental.grow(&cells, &platform, &rules, &go).unwrap();
        if !growth.order.is_empty() && !growth.order.cells().is_empty() {
            let missed = growth.missed_cells();
            if let Some(found) = coherent_field(&cells, &platform, &rules, &growth.order, &missed, &go).unwrap() {
                prop_assert!(found.audit.is_ok());
                prop_assert_eq!(found.field.count(), growth.order.cells().len());
            }
        }
    }
}

/// A block of 8 x 4 x 10 cells whose last column comes `later` layers after the others, as a torn order has it.
fn torn_block(later: usize) -> UniformField {
    let (dims, rows) = ([8, 4, 10], [0xff; 40]);
    let cells = Cells::new(dims, &rows).unwrap();
    let (platform, rules) = (Platform::under(&cells, 4.0).unwrap(), Rules::default());
    let mut layers = vec![Vec::new(); 10 + later];
    for cell in cells.iter() {
        let [x, _, z] = cells.position(cell);
        layers[z as usize + if x < 7 || z == 0 { 0 } else { later }].push(cell);
    }
    let mut order = LayerOrder::new();
    layers.into_iter().for_each(|layer| order.push(layer));
    assert!(audit(&cells, &platform, &rules, &order, &[], &go).unwrap().is_ok());
    coherent_field(&cells, &platform, &rules, &order, &[], &go).unwrap().expect("nothing is shadowed")
}

#[test]
fn a_wait_for_nothing_closes_and_layers_are_a_cell_thick() {
    let UniformField { field, jumps, .. } = torn_block(4);
    assert_eq!((field.torn_share(1.5), jumps), (0.0, 0));
    let thick = |cell: u32| field.value(cell + 32).unwrap() - field.value(cell).unwrap();
    let uneven = (0..9 * 32).map(|cell| (thick(cell) - 1.0).abs()).fold(0.0, f64::max);
    assert!(uneven < 0.3, "{uneven}");
}

#[test]
fn cancelled_work_ends() {
    let rows = [0b111; 6];
    let cells = Cells::new([3, 2, 3], &rows).unwrap();
    let (platform, rules) = (Platform::under(&cells, 4.0).unwrap(), Rules::default());
    let growth = Strategy::Incremental.grow(&cells, &platform, &rules, &go).unwrap();
    let stop = |_| ControlFlow::Break(());
    let found = coherent_field(&cells, &platform, &rules, &growth.order, &[], &stop);
    assert_eq!(found, Err(UniformError::Growth(GrowthError::Cancelled)));
}
