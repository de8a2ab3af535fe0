//! Uniform layers: they pass the audit on whatever solid, and they are even where nothing has to wait.

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::{
    LAGS, LayerField, Spacing, Surface, UniformError, UniformMethod, contour, extend, measure_spacing, plain_field,
    uniform_field,
};
use curvlay_layers::curved::{
    AuditError, Growth, GrowthError, GrowthOptions, Platform, Rules, RulesError, audit, grow,
};
use curvlay_layers::trim::{SurfaceSlices, Trimmer};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::ops::ControlFlow;

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn rows_of(dims: [u32; 3], solid: impl Fn([u32; 3]) -> bool) -> Vec<u64> {
    let [nx, ny, nz] = dims;
    let row = |y, z| (0..nx).filter(|&x| solid([x, y, z])).fold(0, |bits, x| bits | 1 << x);
    (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect()
}

fn grown(cells: &Cells, platform: &Platform) -> (Growth, Vec<u32>) {
    let growth = grow(cells, platform, &Rules::default(), &GrowthOptions::default(), None, &go).unwrap();
    let missed = growth.missed_cells();
    (growth, missed)
}

/// Solids of a few balls and bars, with overhangs and gaps, in a grid of 14 x 10 x 14 cells.
fn solid() -> impl Strategy<Value = Vec<u64>> {
    let part = ([0..14u32, 0..10, 0..14], 1..5u32, prop::bool::ANY);
    (prop::collection::vec(part, 2..7), 0..13u32).prop_map(|(parts, foot)| {
        rows_of([14, 10, 14], |p| {
            let stands = p[2] < 2 && p[0].abs_diff(foot) < 3;
            stands
                || parts.iter().any(|(centre, size, is_ball)| {
                    let away = [0, 1, 2].map(|k| p[k].abs_diff(centre[k]));
                    if *is_ball {
                        away.iter().map(|d| d * d).sum::<u32>() <= size * size
                    } else {
                        away[0] <= 1 && away[1] <= 1 || away[2] <= 1 && away[1] <= 1 && away[0] <= 2 * size
                    }
                })
        })
    })
}

/// The spacing of the surfaces of a field, cut to the cells.
fn spacing(field: &LayerField, cells: &Cells) -> Spacing {
    let extended = extend(field, cells);
    let levels = extended.levels(1.0, 1.0).unwrap();
    let mut surfaces = contour(&extended, &levels, 1.0, Point3::origin(), &go).unwrap();
    for surface in &mut surfaces {
        let Surface { points, triangles, .. } = surface;
        triangles.retain(|t| {
            let middle = t.iter().fold(Vector3::zeros(), |sum, &v| sum + points[v as usize].coords / 3.0);
            middle.iter().all(|&c| c >= 0.0) && cells.contains([middle.x, middle.y, middle.z].map(|c| c as u32))
        });
    }
    let slices: Vec<SurfaceSlices> = surfaces.iter().map(|s| (&s.points[..], &s.triangles[..])).collect();
    measure_spacing(&slices, 1.0, &go).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn even_layers_pass_the_audit_and_keep_what_is_missed(rows in solid(), radius in 4.0..30.0f64) {
        let cells = Cells::new([14, 10, 14], &rows).unwrap();
        let platform = Platform::under(&cells, radius).unwrap();
        let (growth, missed) = grown(&cells, &platform);
        let even = uniform_field(&cells, &platform, &Rules::default(), &growth.order, &missed, &go).unwrap();
        prop_assert_eq!(even.field.count(), growth.order.cells().len());
        prop_assert!(missed.iter().all(|&cell| even.field.value(cell).is_none()));
        let report = audit(&cells, &platform, &Rules::default(), &even.field.rounded(), &missed, &go).unwrap();
        prop_assert!(report.is_ok(), "{report}");
        prop_assert_eq!(&report, &even.audit);
        if let UniformMethod::Clock { lag, .. } = even.method {
            prop_assert!(LAGS.contains(&lag));
            for (layer, of_layer) in (1..).zip(growth.order.iter()) {
                for &cell in of_layer {
                    prop_assert!(even.field.value(cell).unwrap() >= f64::from(layer) - lag);
                }
            }
        }
        prop_assert_eq!(even.jumps, extend(&even.field, &cells).jumps());
    }
}

#[test]
fn a_block_is_cut_into_level_layers() {
    let rows = rows_of([9, 7, 12], |_| true);
    let cells = Cells::new([9, 7, 12], &rows).unwrap();
    let platform = Platform::under(&cells, 20.0).unwrap();
    let (growth, _) = grown(&cells, &platform);
    let even = uniform_field(&cells, &platform, &Rules::default(), &growth.order, &[], &go).unwrap();
    assert_eq!((even.method, even.jumps), (UniformMethod::Clock { lag: LAGS[0], stays_level: true }, 0));
    for cell in cells.iter() {
        assert_eq!(even.field.value(cell), Some(f64::from(cells.position(cell)[2]) + 0.5));
    }
}

#[test]
fn a_roof_on_a_mast_gets_layers_half_as_uneven_as_hop_counts() {
    // From the mast the front goes outwards in all directions: a hop takes it 1 cell along an axis, 1.41 between two.
    let inside = |[x, y, z]: [u32; 3]| {
        let off = [x, y].map(|c| f64::from(c) - 20.0);
        off[0].hypot(off[1]) < if z < 8 { 4.0 } else { 20.0 }
    };
    let rows = rows_of([41, 41, 11], inside);
    let cells = Cells::new([41, 41, 11], &rows).unwrap();
    let platform = Platform::under(&cells, 20.0).unwrap();
    let (growth, missed) = grown(&cells, &platform);
    assert!(missed.is_empty(), "{missed:?}");
    let even = uniform_field(&cells, &platform, &Rules::default(), &growth.order, &missed, &go).unwrap();
    let deviation = |field: &LayerField| {
        let spacing = spacing(field, &cells);
        (spacing.std_mm / spacing.mean_mm, spacing.mean_mm, spacing.squeezed_share)
    };
    let (plain, _, _) = deviation(&plain_field(&cells, &growth.order).unwrap());
    let (evened, mean, squeezed) = deviation(&even.field);
    assert!(evened < plain / 2.0, "{evened} {plain}");
    assert!((mean - 1.0).abs() < 0.03 && squeezed < 0.01, "{mean} {squeezed}");
}

/// A ring that stands upright: the arms wait for each other over and over, in single cells.
#[test]
fn fronts_that_wait_fill_the_part() {
    let (inner, outer, middle) = (13.0, 22.0, 22.0);
    let dims = [44, 6, 44];
    let rows = rows_of(dims, |[x, _, z]| {
        let away = (f64::from(x) + 0.5 - middle).hypot(f64::from(z) + 0.5 - middle);
        (inner..outer).contains(&away)
    });
    let cells = Cells::new(dims, &rows).unwrap();
    let platform = Platform::under(&cells, 60.0).unwrap();
    let (growth, missed) = grown(&cells, &platform);
    let even = uniform_field(&cells, &platform, &Rules::default(), &growth.order, &missed, &go).unwrap();
    assert!(even.jumps * 10 > even.field.count(), "{} jumps", even.jumps);

    // Trimmed to the ring itself: to its staircase of cells, layers would lack pieces in the notches.
    let sides = 120;
    let corner = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k / 4) / f64::from(sides)).sin_cos();
        let radius = if k % 4 < 2 { inner } else { outer };
        Point3::new(middle + radius * cos, f64::from(6 * (k % 2)), middle + radius * sin)
    };
    let points: Vec<_> = (0..4 * sides).map(corner).collect();
    let around = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let next = |k: u32| around.map(|face| face.map(|v| (4 * k + v) % (4 * sides)));
    let triangles: Vec<_> = (0..sides).flat_map(next).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let trimmer = Trimmer::new(&points, &triangles).unwrap();
    let extended = extend(&even.field, &cells);
    let surfaces = contour(&extended, &extended.levels(1.0, 1.0).unwrap(), 1.0, Point3::origin(), &go).unwrap();
    let trimmed = surfaces.iter().map(|surface| trimmer.trim(&surface.points, &surface.triangles, &go).unwrap());
    let sheets: Vec<_> = trimmed.collect();
    let slices: Vec<SurfaceSlices> = sheets.iter().map(|s| (&s.vertices[..], &s.triangles[..])).collect();
    let spacing = measure_spacing(&slices, 1.0, &go).unwrap();
    let wedge = std::f64::consts::TAU / f64::from(sides);
    let volume = f64::from(sides) * wedge.sin() / 2.0 * (outer * outer - inner * inner) * 6.0;
    let filled = spacing.volume_mm3 / volume;
    assert!((filled - 1.0).abs() < 0.01, "{filled}");
}

#[test]
fn the_same_input_gives_the_same_field_on_any_number_of_threads() {
    let rows = rows_of([20, 12, 16], |[x, y, z]| z < 3 && x < 9 || (x + z) % 9 < 4 && y > 2 || z == 9);
    let cells = Cells::new([20, 12, 16], &rows).unwrap();
    let platform = Platform::under(&cells, 30.0).unwrap();
    let (growth, missed) = grown(&cells, &platform);
    let run = || uniform_field(&cells, &platform, &Rules::default(), &growth.order, &missed, &go).unwrap();
    let bits = |field: &[f64]| field.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    let (one, other) = (with(1), with(4));
    assert_eq!(bits(one.field.values()), bits(other.field.values()));
    assert_eq!((one.method, &one.audit, one.jumps), (other.method, &other.audit, other.jumps));
}

#[test]
fn what_cannot_be_retimed_is_refused() {
    let cells = Cells::new([1, 1, 3], &[1, 1, 1]).unwrap();
    let platform = Platform::under(&cells, 3.0).unwrap();
    let rules = Rules::default();
    let order_of = |layers: &[&[u32]]| {
        let mut order = LayerOrder::new();
        layers.iter().for_each(|layer| order.push(layer.iter().copied()));
        order
    };
    let run = |order: &LayerOrder, missed: &[u32], rules: &Rules| {
        uniform_field(&cells, &platform, rules, order, missed, &go).unwrap_err()
    };
    assert!(matches!(run(&LayerOrder::new(), &[], &rules), UniformError::Field(_)));
    assert!(matches!(run(&order_of(&[&[7]]), &[], &rules), UniformError::Field(_)));
    // A cell in the air, and nothing that carries it.
    assert!(matches!(run(&order_of(&[&[0], &[2]]), &[1], &rules), UniformError::Order(_)));
    // A cell that is neither built nor missed.
    assert!(matches!(run(&order_of(&[&[0], &[1]]), &[], &rules), UniformError::Order(_)));
    let unsound = Rules { inside_depth_cells: -1.0, ..rules };
    let refused = run(&order_of(&[&[0], &[1], &[2]]), &[], &unsound);
    assert!(matches!(
        refused,
        UniformError::Growth(GrowthError::Rules(RulesError::InsideDepth { .. }))
            | UniformError::Growth(GrowthError::Hull(_))
    ));
    let whole = order_of(&[&[0], &[1], &[2]]);
    let stop = |_| ControlFlow::Break(());
    let cancelled = uniform_field(&cells, &platform, &rules, &whole, &[], &stop).unwrap_err();
    assert!(matches!(
        cancelled,
        UniformError::Growth(GrowthError::Cancelled) | UniformError::Audit(AuditError::Cancelled)
    ));
    // What the clock cannot do the order itself does: three cells, each in its layer.
    assert_eq!(plain_field(&cells, &whole).unwrap().rounded(), whole);
}
