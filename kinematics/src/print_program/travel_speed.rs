//! The speed of a travel by joints.

use super::knot::TargetOptions;
use crate::program::Speed;
use crate::workcell::Workcell;
use nalgebra::Vector3;

/// The speed from where the program was started: slow, since that way was not planned. In mm/s of the tip and rad/s of the fastest joint.
const FROM_ANYWHERE: Speed = Speed { mm_s: 50.0, rad_s: 0.2 };

/// Chords along the way of the tip: where it goes fastest it is at most 2 % faster than its chord, by the property test.
const CHORDS: u32 = 32;

/// The speed of a straight motion of the joints: that of the fastest one, so low that the tip goes over the part by no more than
/// [`TargetOptions::travel_mm_s`] where it is fastest, and the mean of the tip then, as controllers take the length of the way by its speed. Controllers that
/// take a share of what their axes can do know no speed of the tip.
pub(super) fn travel_speed<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    from: Option<[f64; N]>,
    to: &[f64; N],
    options: &TargetOptions,
) -> Speed {
    let Some(from) = from else { return FROM_ANYWHERE };
    let TargetOptions { travel_mm_s, travel_rad_s, .. } = *options;
    let turn = from.iter().zip(to).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max);
    let tip = |k: u32| {
        let share = f64::from(k) / f64::from(CHORDS);
        let joints = std::array::from_fn(|joint| from[joint] + share * (to[joint] - from[joint]));
        workcell.nozzle_on_part(&joints).map(|nozzle| nozzle.translation.vector)
    };
    let tips: Vec<Vector3<f64>> = (0..=CHORDS).filter_map(tip).collect();
    let chords = || tips.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    let way_mm: f64 = chords().sum();
    // The way if all of it were as fast as the fastest chord.
    let fastest_mm = f64::from(CHORDS) * chords().fold(0.0, f64::max);
    // NaN where nothing moves, which `min` drops.
    let mm_s = travel_mm_s * (way_mm / fastest_mm).min(1.0);
    Speed { mm_s, rad_s: (turn * travel_mm_s / fastest_mm).min(travel_rad_s) }
}

#[cfg(all(test, feature = "serde"))]
mod tests {
    use super::*;
    use crate::workcell::AnyWorkcell;
    use proptest::prelude::*;

    proptest! {
        /// By small steps of the motion, whatever the joints.
        #[test]
        fn the_tip_is_no_faster_than_it_may(
            from in prop::array::uniform6(-1.5_f64..1.5),
            by in prop::array::uniform6(-0.6_f64..0.6),
            travel_mm_s in 20.0_f64..400.0,
        ) {
            let file = include_str!("../../../examples/cells/ur10.json");
            let Ok(AnyWorkcell::Six(cell)) = AnyWorkcell::from_json(file.as_bytes()) else { panic!("it has six axes") };
            let to: [f64; 6] = std::array::from_fn(|k| from[k] + by[k]);
            let options = TargetOptions { travel_mm_s, ..TargetOptions::default() };
            let speed = travel_speed(&cell, Some(from), &to, &options);
            let turn = by.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
            let seconds = turn / speed.rad_s;
            let tip = |share: f64| {
                let joints = std::array::from_fn(|k| from[k] + share * by[k]);
                cell.nozzle_on_part(&joints).unwrap().translation.vector
            };
            let step = 1e-3;
            let steps: Vec<f64> =
                (0..1000).map(|k| (tip(step * f64::from(k + 1)) - tip(step * f64::from(k))).norm()).collect();
            let (way, most) = (steps.iter().sum::<f64>(), steps.iter().fold(0.0, |most: f64, step| most.max(*step)));
            // By the joints, and by the length of the way.
            let fastest = [seconds, way / speed.mm_s].map(|seconds| most / (step * seconds));
            prop_assert!(fastest.iter().all(|fastest| *fastest < 1.02 * travel_mm_s), "{fastest:?} of {travel_mm_s} mm/s");
            prop_assert!(speed.rad_s <= options.travel_rad_s);
            prop_assert!(fastest[1] > 0.98 * travel_mm_s);
            prop_assert!(fastest[0] > 0.98 * travel_mm_s || speed.rad_s > 0.999 * options.travel_rad_s, "{fastest:?}");
        }
    }

    #[test]
    fn unknown_and_no_ways() {
        let file = include_str!("../../../examples/cells/ur10.json");
        let Ok(AnyWorkcell::Six(cell)) = AnyWorkcell::from_json(file.as_bytes()) else { panic!("it has six axes") };
        let options = TargetOptions::default();
        assert_eq!(travel_speed(&cell, None, &[0.1; 6], &options), FROM_ANYWHERE);
        assert_eq!(travel_speed(&cell, Some([0.1; 6]), &[0.1; 6], &options), Speed { mm_s: 250.0, rad_s: 1.0 });
    }
}
