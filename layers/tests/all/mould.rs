//! Growth that starts on a mould: beside a literal twin, by all strategies, under the audit; and what is refused.

use crate::common::{Part, are_neighbours, centre, go, random_rows, tip_1_mm};
use curvlay_hull::{ConvexHull, Depth};
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::uniform_field;
use curvlay_layers::curved::{
    Fault, Growth, GrowthError, JudgedByNozzle, MissedReason, NozzleRule, Platform, PlatformError, Prevention, Rules,
    RulesError, Strategy as Grown, SupportOptions, add_support, audit, audit_with_nozzle, check_impossible,
    grow_with_nozzle, prove_impossible,
};
use curvlay_layers::nalgebra::Point3;
use proptest::prelude::*;

/// A mould and what is grown on it, in one grid.
#[derive(Clone, Debug)]
struct Job {
    part: Part,
    mould: Vec<u64>,
}

impl Job {
    /// Cells of the part and of the mould by their place.
    fn new(dims: [u32; 3], platform: Platform, of: impl Fn([u32; 3]) -> Option<bool>) -> Job {
        let mut both = [vec![0u64; (dims[1] * dims[2]) as usize], vec![0u64; (dims[1] * dims[2]) as usize]];
        for (z, y, x) in (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| (z, y, x))))
        {
            if let Some(is_mould) = of([x, y, z]) {
                both[usize::from(is_mould)][(y + dims[1] * z) as usize] |= 1 << x;
            }
        }
        let [rows, mould] = both;
        let platform = platform.on_mould(&Cells::new(dims, &mould).unwrap()).unwrap();
        Job { part: Part { dims, rows, platform }, mould }
    }

    fn mould(&self) -> Cells<'_> {
        Cells::new(self.part.dims, &self.mould).unwrap()
    }

    fn hull(&self, rules: &Rules, built: &[u32]) -> ConvexHull {
        let cells = self.part.cells();
        let depth = if rules.boundary_is_inside {
            Depth::new(2.0 * rules.inside_depth_cells)
        } else {
            Depth::beyond(2.0 * rules.inside_depth_cells)
        }
        .unwrap();
        let mut hull = ConvexHull::column(self.part.platform.corners(), 0, depth).unwrap();
        let mould = self.mould();
        let points: Vec<_> =
            mould.iter().chain(built.iter().copied()).map(|cell| centre(cells.position(cell))).collect();
        hull.insert(&points).unwrap();
        hull
    }

    /// Algorithm 1, to the letter, with the mould built before.
    fn literal_greedy(&self, rules: &Rules) -> Vec<Vec<u32>> {
        let (cells, mould) = (self.part.cells(), self.mould());
        let hull = self.hull(rules, &[]);
        let is_beside = |a: u32, b: u32| {
            let (a, b) = (cells.position(a), cells.position(b));
            (0..3).map(|k| a[k].abs_diff(b[k])).sum::<u32>() == 1
        };
        let carried = self.part.standing();
        let first =
            cells.iter().filter(|cell| carried.contains(cell) || mould.iter().any(|other| is_beside(*cell, other)));
        let mut layer: Vec<u32> = first.filter(|&cell| !hull.is_deep(centre(cells.position(cell)))).collect();
        let (mut built, mut layers): (Vec<u32>, _) = (Vec::new(), Vec::new());
        while !layer.is_empty() {
            built.extend(&layer);
            layers.push(layer);
            let hull = self.hull(rules, &built);
            let can_be = |&cell: &u32| {
                !built.contains(&cell)
                    && built.iter().any(|&other| are_neighbours(&cells, cell, other, rules.neighbours))
                    && !hull.is_deep(centre(cells.position(cell)))
            };
            layer = cells.iter().filter(can_be).collect();
        }
        layers
    }
}

fn square(size: f64) -> Platform {
    Platform::polygon(&[[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]]).unwrap()
}

/// Random moulds below random parts, with overhangs and loose pieces.
fn jobs() -> impl Strategy<Value = Job> {
    ((3u32..7, 2u32..6, 3u32..7), any::<u64>(), any::<u64>(), any::<bool>()).prop_filter_map(
        "stands",
        |((nx, ny, nz), a, b, small)| {
            let (of_mould, of_part) = (random_rows(a, ny * nz, nx, 4), random_rows(b, ny * nz, nx, 7));
            let bit = |rows: &[u64], [x, y, z]: [u32; 3]| rows[(y + ny * z) as usize] >> x & 1 == 1;
            let of = |at: [u32; 3]| match at[2] < nz / 2 && bit(&of_mould, at) {
                true => Some(true),
                false => bit(&of_part, at).then_some(false),
            };
            if !(0..nz / 2).any(|z| (0..ny).any(|y| of_mould[(y + ny * z) as usize] != 0)) {
                return None;
            }
            let job = Job::new([nx, ny, nz], square(if small { 2.0 } else { 8.0 }), of);
            (!job.literal_greedy(&Rules::default()).is_empty()).then_some(job)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn greedy_is_the_literal_one(job in jobs(), eps in prop::sample::select(vec![0.5, 1.0, 2.0])) {
        let rules = Rules { inside_depth_cells: eps, ..Rules::default() };
        let known = job.literal_greedy(&rules);
        let found = Grown::Greedy.grow(&job.part.cells(), &job.part.platform, &rules, &go);
        match found {
            Ok(growth) => {
                let layers: Vec<Vec<u32>> = growth.order.iter().map(<[u32]>::to_vec).collect();
                prop_assert_eq!(layers, known);
            }
            Err(error) => prop_assert!(known.is_empty() && error == GrowthError::NothingOnPlatform, "{error}"),
        }
    }

    #[test]
    fn every_strategy_passes_the_audit(job in jobs()) {
        let (cells, platform, rules) = (job.part.cells(), &job.part.platform, Rules::default());
        let all = [
            Grown::Greedy, Grown::Incremental, Grown::Adaptive, Grown::Governed(Prevention::Adaptive),
            Grown::Printed(Prevention::Incremental), Grown::Unbuild,
        ];
        for strategy in all {
            let growth = strategy.grow(&cells, platform, &rules, &go).unwrap();
            let missed = growth.missed_cells();
            let report = audit(&cells, platform, &rules, &growth.order, &missed, &go).unwrap();
            prop_assert!(report.is_ok(), "{strategy}: {report}");
            let uniform = uniform_field(&cells, platform, &rules, &growth.order, &missed, &go).unwrap();
            prop_assert!(uniform.audit.is_ok());
            let judge = |growth: &Growth| {
                let judged = JudgedByNozzle { rule: tip_1_mm(), cell_mm: 2.0, steps: 1, cells: &growth.nozzle };
                audit_with_nozzle(&cells, platform, &rules, &judged, &growth.order, &growth.missed_cells(), &go).unwrap()
            };
            let further = grow_with_nozzle(&cells, 2.0, platform, &rules, &tip_1_mm(), growth, &go).unwrap();
            let report = judge(&further);
            prop_assert!(report.is_ok(), "{strategy} with the nozzle: {report}");
        }
    }

    #[test]
    fn what_is_proved_impossible_is_checked_and_missed(job in jobs()) {
        let (cells, platform, rules) = (job.part.cells(), &job.part.platform, Rules::default());
        let growth = Grown::Unbuild.grow(&cells, platform, &rules, &go).unwrap();
        let missed = growth.missed_cells();
        let proofs = prove_impossible(&cells, platform, &rules, &missed, &go).unwrap();
        prop_assert!(check_impossible(&cells, platform, &rules, &proofs).is_ok());
        let hull = job.hull(&rules, &[]);
        for cell in cells.iter().filter(|&cell| hull.is_deep(centre(cells.position(cell)))) {
            prop_assert!(missed.contains(&cell));
            let missed = growth.missed.iter().find(|missed| missed.cell == cell).unwrap();
            prop_assert_eq!(missed.reason, MissedReason::Shadowed { layer: 0 });
        }
    }
}

/// The mould of Dai 2020, section 5.3.2, drawn smaller: a block with a cylindrical top of 80 degrees, and a bar of 4 layers on it.
fn arc() -> (Job, impl Fn([u32; 3]) -> f64) {
    let (radius, layers): (f64, f64) = (30.0, 4.0);
    let half = radius * 40f64.to_radians().sin();
    let centre_z = 6.0 - radius * 40f64.to_radians().cos();
    let above = move |[x, _, z]: [u32; 3]| (f64::from(x) + 0.5 - 22.0).hypot(f64::from(z) + 0.5 - centre_z) - radius;
    let job = Job::new([44, 5, 20], square(44.0), move |at| {
        let across = f64::from(at[0]) + 0.5 - 22.0;
        let angle = (across / (above(at) + radius)).asin().to_degrees();
        match above(at) < 0.0 && across.abs() < half {
            true => Some(true),
            false => (above(at) < layers && above(at) >= 0.0 && angle.abs() < 37.5).then_some(false),
        }
    });
    (job, above)
}

#[test]
fn layers_follow_the_arc_of_a_mould() {
    let (job, above) = arc();
    let (cells, platform, rules) = (job.part.cells(), &job.part.platform, Rules::default());
    let growth = Grown::Incremental.grow(&cells, platform, &rules, &go).unwrap();
    assert!(growth.missed.is_empty(), "{} missed", growth.missed.len());
    let uniform = uniform_field(&cells, platform, &rules, &growth.order, &[], &go).unwrap();
    // The field is the height above the mould, within the steps of the cells.
    for cell in cells.iter() {
        let (value, known) = (uniform.field.value(cell).unwrap(), above(cells.position(cell)));
        assert!((value - known).abs() < 1.1, "cell {:?}: {value}, {known} above the mould", cells.position(cell));
    }
    // Without the mould the arc stands on nothing.
    let bare = square(44.0);
    let error = Grown::Incremental.grow(&cells, &bare, &rules, &go).unwrap_err();
    assert_eq!(error, GrowthError::NothingOnPlatform);
    let report = audit(&cells, &bare, &rules, &growth.order, &[], &go).unwrap();
    assert_eq!(report.counts.unsupported, growth.order.layer(0).len());
}

/// A block with a cylindrical top, as a mesh.
fn block(radius: f64, half: f64, side: f64, base: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let steps = 24;
    let mut outline = vec![[half, base], [-half, base]];
    outline.extend((0..=steps).map(|k| {
        let x = -half + 2.0 * half * f64::from(k) / f64::from(steps);
        [x, base + 6.0 + (radius * radius - x * x).sqrt() - (radius * radius - half * half).sqrt()]
    }));
    let n = outline.len() as u32;
    let points =
        [0.0, side].iter().flat_map(|&y| outline.iter().map(move |&[x, z]| Point3::new(x + 22.0, y, z))).collect();
    let mut triangles = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        triangles.extend([[k, n + k, next], [next, n + k, n + next]]);
        if k > 0 && next > 0 {
            triangles.extend([[0, k, next], [n, n + next, n + k]]);
        }
    }
    (points, triangles)
}

#[test]
fn a_mesh_becomes_the_cells_with_their_centre_inside() {
    let (radius, half) = (30.0, 30.0 * 40f64.to_radians().sin());
    let dims = [44, 5, 20];
    let inside = |points: &[Point3<f64>], triangles: &[[u32; 3]]| {
        let moved: Vec<Point3<f64>> =
            points.iter().map(|p| Point3::from(p.coords * 0.5) + Point3::new(1.0, 2.0, 3.0).coords).collect();
        square(44.0).on_mould_mesh(dims, 0.5, Point3::new(1.0, 2.0, 3.0), &moved, triangles)
    };
    let (points, triangles) = block(radius, half, 4.9, -2.0);
    let platform = inside(&points, &triangles).unwrap();
    let mould = platform.mould().unwrap();
    for cell in 0..44 * 5 * 20 {
        let at = mould.position(cell);
        let [x, y, z] = at.map(|k| f64::from(k) + 0.5);
        let across: f64 = x - 22.0;
        let top = 4.0 + (radius * radius - across * across).sqrt() - (radius * radius - half * half).sqrt();
        // Between chord and arc is less than a tenth of a cell.
        if across.abs() < half && (z - top).abs() > 0.1 {
            assert_eq!(mould.contains(at), z < top && y < 4.9, "{at:?}");
        }
    }
    let (far, _) = block(radius, half, 6.0, 0.0);
    assert!(matches!(inside(&far, &triangles), Err(PlatformError::MouldBeyondGrid { .. })));
    let (small, _) = block(0.2, 0.1, 0.1, -6.1);
    assert_eq!(inside(&small, &triangles), Err(PlatformError::EmptyMould));
    assert!(matches!(inside(&points, &[[0, 1, 999]]), Err(PlatformError::MouldMesh(_))));
}

#[test]
fn cells_of_the_mould_and_other_grids_are_refused() {
    let (job, _) = arc();
    let (platform, rules) = (&job.part.platform, Rules::default());
    let both: Vec<u64> = job.part.rows.iter().zip(&job.mould).map(|(a, b)| a | b).collect();
    let cells = Cells::new(job.part.dims, &both).unwrap();
    let common = RulesError::InMould { cells: job.mould().count() };
    assert_eq!(Grown::Greedy.grow(&cells, platform, &rules, &go), Err(GrowthError::Rules(common)));
    assert!(audit(&cells, platform, &rules, &LayerOrder::new(), &[], &go).is_err());
    assert_eq!(platform.outside_mould(&cells).unwrap(), job.part.rows);
    let rows = [1];
    let other = Cells::new([1, 1, 1], &rows).unwrap();
    let grid = RulesError::MouldGrid { mould: job.part.dims, cells: [1, 1, 1] };
    assert_eq!(Grown::Unbuild.grow(&other, platform, &rules, &go), Err(GrowthError::Rules(grid)));
    assert_eq!(platform.outside_mould(&other), Err(grid));
}

/// In a trough all of the part lies inside the hull of the mould. The nozzle gets there, and must keep clear of the walls.
#[test]
fn a_trough_is_filled_by_the_nozzle_alone() {
    let job = Job::new([30, 18, 6], square(30.0), |[x, y, z]| {
        let in_trough = (3..27).contains(&x) && (2..16).contains(&y);
        let of_part = (8..22).contains(&x) && (8..10).contains(&y) && z < 3;
        (z < 1 || !in_trough && z < 5).then_some(true).or(of_part.then_some(false))
    });
    let (cells, platform, rules) = (job.part.cells(), &job.part.platform, Rules::default());
    assert_eq!(Grown::Incremental.grow(&cells, platform, &rules, &go), Err(GrowthError::NothingOnPlatform));
    let nozzle = NozzleRule { block_mm: 6.0, cone_height_mm: 8.0, half_angle: 0.3, ..tip_1_mm() };
    let growth = grow_with_nozzle(&cells, 1.0, platform, &rules, &nozzle, Growth::default(), &go).unwrap();
    assert!(growth.missed.is_empty(), "{} missed", growth.missed.len());
    let judged = JudgedByNozzle { rule: nozzle, cell_mm: 1.0, steps: 1, cells: &growth.nozzle };
    let report = audit_with_nozzle(&cells, platform, &rules, &judged, &growth.order, &[], &go).unwrap();
    assert!(report.is_ok(), "{report}");
    // A wider one meets the walls, and the audit says so.
    let wide = NozzleRule { block_mm: 24.0, cone_height_mm: 2.0, ..nozzle };
    let judged = JudgedByNozzle { rule: wide, ..judged };
    let report = audit_with_nozzle(&cells, platform, &rules, &judged, &growth.order, &[], &go).unwrap();
    let of_mould = |fault: &Fault| matches!(fault, Fault::NozzleMeets { other, .. } if job.mould().iter().any(|cell| cell == *other));
    assert!(report.faults.iter().any(of_mould), "{report}");
    // By the hull rule alone every cell is at fault.
    let report = audit(&cells, platform, &rules, &growth.order, &[], &go).unwrap();
    assert!(report.counts.inside > 0);
}

/// A mast on a block, with an arm whose end hangs down: the column below it ends on the block, a level above the plate.
#[test]
fn support_stands_on_the_mould() {
    let wide = Platform::polygon(&[[-20.0, -20.0], [27.0, -20.0], [27.0, 21.0], [-20.0, 21.0]]).unwrap();
    let job = Job::new([7, 1, 8], wide, |[x, _, z]| match (x, z) {
        (_, 0) => Some(true),
        (0, _) | (_, 7) => Some(false),
        (6, 5..) => Some(false),
        _ => None,
    });
    let (cells, platform, rules) = (job.part.cells(), &job.part.platform, Rules::default());
    let grow = |cells: &Cells| Grown::Incremental.grow(cells, platform, &rules, &go);
    let growth = grow(&cells).unwrap();
    assert!(!growth.missed.is_empty());
    let options = SupportOptions { width: 1, ..SupportOptions::default() };
    let supported = add_support(&cells, platform, &rules, &growth, &[], &options, &grow, &go).unwrap().unwrap();
    assert_eq!(supported.support, [13, 20, 27, 34]);
    assert!(supported.growth.missed.is_empty());
}
