//! The clock of stages.

use curvlay_examples::clock::StageClock;
use std::sync::Barrier;
use std::thread::{self, sleep};
use std::time::Duration;

const STEP: Duration = Duration::from_millis(20);

#[test]
fn time_belongs_to_the_stage_that_ran() {
    let clock = StageClock::default();
    sleep(STEP); // of no stage
    clock.note("one", 0);
    sleep(STEP);
    clock.note("one", 1);
    clock.note("two", 0);
    sleep(STEP);
    // Of stage three, which has done something since.
    clock.note("three", 1);
    sleep(STEP);
    clock.stop();
    sleep(STEP);
    let times = ["one", "two", "three"].map(|stage| clock.on_the_clock(&[stage]));
    assert!(times[0] >= STEP && times[1] < STEP && times[2] >= 2 * STEP, "{times:?}");
    assert_eq!(times.iter().sum::<Duration>(), clock.on_the_clock(&["one", "two", "three", "none"]));
    assert_eq!(clock.of_threads(&["one", "three"]), times[0] + times[2]);
}

#[test]
fn threads_add_up() {
    let clock = StageClock::default();
    let together = Barrier::new(3);
    thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                clock.note("work", 0);
                together.wait();
                sleep(5 * STEP);
                clock.note("work", 1);
            });
        }
    });
    assert!(clock.of_threads(&["work"]) >= 15 * STEP);
    assert!(clock.on_the_clock(&["work"]) < clock.of_threads(&["work"]));
}
