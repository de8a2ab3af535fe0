//! Support: what it carries, that it stays out of the part, and parts that are complete with it.

use crate::common::{Part, are_neighbours, go, parts, tip_1_mm};
use curvlay_layers::Progress;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{UniformMethod, uniform_field};
use curvlay_layers::curved::{
    CellMesh, Growth, GrowthError, GrowthOptions, Guides, LayerOptions, LayersBy, LayersError, MissedCell,
    MissedReason, NoSupport, NozzleRule, NozzleRuleError, NozzleUse, PartSupport, Platform, Rules, Strategy,
    SupportError, SupportOptions, Supported, Workpiece, add_support, audit, cell_mesh, grow,
};
use curvlay_layers::nalgebra::Point3;
use proptest::prelude::*;
use proptest::strategy::Strategy as _;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

fn part(dims: [u32; 3], is_solid: impl Fn([u32; 3]) -> bool) -> Part {
    let [nx, ny, nz] = dims;
    let row = |y, z| (0..nx).fold(0, |row, x| row | u64::from(is_solid([x, y, z])) << x);
    let rows: Vec<u64> = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect();
    let platform = Platform::under(&Cells::new(dims, &rows).unwrap(), 40.0).unwrap();
    Part { dims, rows, platform }
}

fn grown(part: &Part, cells: &Cells, rules: &Rules) -> Result<Growth, GrowthError> {
    grow(cells, &part.platform, rules, &GrowthOptions::default(), None, &go)
}

fn supported(part: &Part, rules: &Rules, options: &SupportOptions) -> (Growth, Result<Supported, NoSupport>) {
    let growth = grown(part, &part.cells(), rules).unwrap();
    let again = |cells: &Cells| grown(part, cells, rules);
    let supported = add_support(&part.cells(), &part.platform, rules, &growth, &[], options, &again, &go).unwrap();
    (growth, supported)
}

/// A ball that hangs below a beam on two posts.
fn hanging_ball() -> Part {
    part([31, 11, 27], |[x, y, z]: [u32; 3]| {
        let [dx, dy, dz] = [f64::from(x) - 15.0, f64::from(y) - 5.0, f64::from(z) - 12.0];
        let post = !(2..=28).contains(&x) && (4..7).contains(&y);
        let beam = z >= 24 && (4..7).contains(&y);
        let stem = (14..17).contains(&x) && (4..7).contains(&y) && z > 12;
        post || beam || stem || dx * dx + dy * dy + dz * dz < 5.2 * 5.2
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Part and support pass the audit as one solid, the support is outside of the part, and fewer cells are missed than without.
    #[test]
    fn part_and_support_are_one_solid_that_can_be_built(
        part in parts((4u32..10, 1u32..7, 4u32..10).prop_map(|(x, y, z)| [x, y, z]), 2..6),
        (width, contact) in (1u32..5).prop_flat_map(|width| (Just(width), 1..=width)),
        gap in 0u32..3,
    ) {
        let rules = Rules::default();
        let (before, after) = supported(&part, &rules, &SupportOptions { width, contact, gap, rounds: 3 });
        let Ok(Supported { rows, growth, support, gap: empty, rounds, .. }) = after else { return Ok(()) };
        prop_assert!(growth.missed.len() < before.missed.len() && (1..=3).contains(&rounds));
        let united = Cells::new(part.dims, &rows).unwrap();
        prop_assert!(support.is_sorted() && support.iter().all(|&cell| !part.cells().contains(united.position(cell))));
        let all: Vec<u32> = part.cells().iter().chain(support.iter().chain(&empty).copied()).collect();
        prop_assert_eq!(all.iter().copied().collect::<BTreeSet<u32>>(), united.iter().collect::<BTreeSet<u32>>());
        prop_assert_eq!(all.len(), united.count());
        prop_assert!(!support.is_empty() && empty.is_sorted() && (gap > 0 || empty.is_empty()));
        let report = audit(&united, &part.platform, &rules, &growth.order, &growth.missed_cells(), &go).unwrap();
        prop_assert!(report.is_ok(), "{}", report);
        prop_assert!(growth.missed.iter().all(|missed| part.cells().contains(united.position(missed.cell))));
    }
}

#[test]
fn a_hanging_ball_stands_on_one_column() {
    let part = hanging_ball();
    let options = SupportOptions { width: 1, ..SupportOptions::default() };
    let (before, after) = supported(&part, &Rules::default(), &options);
    let Supported { growth, support, straight_cells, rounds, .. } = after.unwrap();
    assert!(before.missed.len() > 400);
    assert_eq!((growth.missed.len(), rounds), (0, 1));
    // Seven cells from the plate to the lowest one of the ball, one a level.
    let levels: Vec<u32> = support.iter().map(|&cell| part.cells().position(cell)[2]).collect();
    assert_eq!(levels, (0..7).collect::<Vec<_>>());
    assert!(2 * support.len() < straight_cells);
}

/// The straight columns are counted by hand for a bar of three cells that hangs at its end.
#[test]
fn straight_columns_are_those_below_all_missed_cells() {
    let part = part([7, 1, 9], |[x, _, z]| x == 0 || z == 8 || (x == 6 && z > 4));
    let (before, after) =
        supported(&part, &Rules::default(), &SupportOptions { width: 1, ..SupportOptions::default() });
    assert_eq!(before.missed.iter().map(|missed| part.cells().position(missed.cell)[2]).collect::<Vec<_>>(), [5, 6]);
    let Supported { support, straight_cells, .. } = after.unwrap();
    assert_eq!((support.len(), straight_cells), (5, 5));
}

/// Columns touch the part with one cell a level, are as wide as asked for where they do not, and lean round the part.
#[test]
fn columns_are_wide_below_and_thin_where_they_touch() {
    let part = hanging_ball();
    let cells = part.cells();
    let (_, after) = supported(&part, &Rules::default(), &SupportOptions { width: 3, ..SupportOptions::default() });
    let support = after.unwrap().support;
    let mut of_level: BTreeMap<u32, usize> = BTreeMap::new();
    support.iter().for_each(|&cell| *of_level.entry(cells.position(cell)[2]).or_default() += 1);
    let touches =
        |cell: u32| cells.iter().any(|other| are_neighbours(&cells, cell, other, Rules::default().neighbours));
    assert_eq!(support.iter().filter(|&&cell| touches(cell)).count(), 1);
    assert_eq!(of_level.values().copied().collect::<Vec<_>>(), [9, 9, 9, 9, 9, 9, 1]);

    // As wide as asked for where they touch, and short of the part by as many levels as asked for.
    let of_levels = |options: SupportOptions| {
        let Supported { support, gap, growth, .. } = supported(&part, &Rules::default(), &options).1.unwrap();
        assert!(growth.missed.is_empty());
        [support, gap].map(|of| {
            let mut of_level: BTreeMap<u32, usize> = BTreeMap::new();
            of.iter().for_each(|&cell| *of_level.entry(cells.position(cell)[2]).or_default() += 1);
            of_level.into_iter().collect::<Vec<_>>()
        })
    };
    let wide = |levels: std::ops::Range<u32>| levels.map(|level| (level, 9)).collect::<Vec<_>>();
    let options = SupportOptions { contact: 3, ..SupportOptions::default() };
    assert_eq!(of_levels(options), [wide(0..7), Vec::new()]);
    let options = SupportOptions { gap: 2, ..SupportOptions::default() };
    assert_eq!(of_levels(options), [wide(0..5), vec![(5, 9), (6, 1)]]);
    // A column that would be all gap is printed whole.
    let options = SupportOptions { gap: 7, ..SupportOptions::default() };
    assert_eq!(of_levels(options), [[wide(0..6), vec![(6, 1)]].concat(), Vec::new()]);

    // Below few cells near the plate, columns of three cells would be more than half of straight ones.
    let floating = crate::support::part([9, 3, 5], |[x, y, z]: [u32; 3]| x < 3 || (x > 5 && y < 2 && z == 3));
    let (before, after) = supported(&floating, &Rules::default(), &SupportOptions::default());
    let Supported { growth, support, straight_cells, .. } = after.unwrap();
    assert_eq!((before.missed.len(), growth.missed.len()), (6, 0));
    assert_eq!((support.len(), straight_cells), (4 + 4 + 1, 18));

    // A roof right under the arm: the column goes round it, or lands on it.
    let part = crate::support::part([9, 1, 12], |[x, _, z]| {
        x == 0 || z == 11 || (x == 8 && z > 7) || (x > 3 && x < 8 && z == 4)
    });
    let (before, after) =
        supported(&part, &Rules::default(), &SupportOptions { width: 1, ..SupportOptions::default() });
    assert!(!before.missed.is_empty());
    let Supported { growth, support, .. } = after.unwrap();
    assert!(growth.missed.len() < before.missed.len());
    assert!(!support.is_empty());
}

#[test]
fn support_that_cannot_be_is_refused_and_none_is_needed_where_nothing_is_missed() {
    let tower = part([3, 3, 4], |_| true);
    let (_, none) = supported(&tower, &Rules::default(), &SupportOptions::default());
    assert_eq!(none, Err(NoSupport::NotNeeded));
    let (_, none) =
        supported(&hanging_ball(), &Rules::default(), &SupportOptions { rounds: 0, ..SupportOptions::default() });
    assert_eq!(none, Err(NoSupport::Forbidden));
    let part = hanging_ball();
    let growth = grown(&part, &part.cells(), &Rules::default()).unwrap();
    let again = |cells: &Cells| grown(&part, cells, &Rules::default());
    let with = |width: u32, progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)| {
        let options = SupportOptions { width, ..SupportOptions::default() };
        add_support(&part.cells(), &part.platform, &Rules::default(), &growth, &[], &options, &again, progress)
    };
    for width in [0, 65] {
        assert_eq!(with(width, &go), Err(SupportError::Width { width }));
    }
    let with_options =
        |options| add_support(&part.cells(), &part.platform, &Rules::default(), &growth, &[], &options, &again, &go);
    for (contact, width) in [(0, 3), (4, 3)] {
        let refused = with_options(SupportOptions { contact, width, ..SupportOptions::default() });
        assert_eq!(refused, Err(SupportError::Contact { contact, width }));
    }
    let refused = with_options(SupportOptions { gap: 65, ..SupportOptions::default() });
    assert_eq!(refused, Err(SupportError::Gap { gap: 65 }));
    let stop = |_: Progress| ControlFlow::Break(());
    assert_eq!(with(3, &stop), Err(SupportError::Growth(GrowthError::Cancelled)));
    let fails = |_: &Cells| Err(GrowthError::NothingOnPlatform);
    let failed =
        add_support(&part.cells(), &part.platform, &Rules::default(), &growth, &[], &Default::default(), &fails, &go);
    assert_eq!(failed, Err(SupportError::Growth(GrowthError::NothingOnPlatform)));
}

/// The skin of cells is closed, encloses their volume, and looks outwards, also where cells touch along an edge.
#[test]
fn the_skin_of_cells_is_closed() {
    for seed in 0..20 {
        let rows = crate::common::random_rows(seed, 20, 6, 4);
        let cells = Cells::new([6, 4, 5], &rows).unwrap();
        let members: Vec<u32> = cells.iter().collect();
        let mesh = cell_mesh(&cells, &members, 0.5, Point3::new(1.0, 2.0, 3.0));
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        let mut volume = 0.0;
        for &[a, b, c] in &mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
            let [a, b, c] = [a, b, c].map(|corner| mesh.vertices[corner as usize] - Point3::new(1.0, 2.0, 3.0));
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        assert!(edges.values().all(|&balance| balance == 0));
        assert!((volume - members.len() as f64 / 8.0).abs() < 1e-9);
    }
}

/// A part whose cells, a millimetre wide, are its mesh.
/// Incremental orders, layers of 1 mm, all else by default.
fn incremental() -> LayerOptions {
    LayerOptions {
        strategy: Some(Strategy::Incremental),
        height_mm: Some(1.0),
        rule: tip_1_mm(),
        ..LayerOptions::default()
    }
}

fn workpiece<'a>(part: &'a Part, mesh: &'a CellMesh) -> Workpiece<'a> {
    let cells = part.cells();
    let volume_mm3 = cells.iter().count() as f64;
    let (cell_mm, origin, rules) = (1.0, Point3::origin(), Rules::default());
    let (vertices, triangles, platform) = (&mesh.vertices, &mesh.triangles, &part.platform);
    Workpiece { vertices, triangles, cells, cell_mm, origin, platform, rules, volume_mm3, guides: Guides::default() }
}

fn mesh_of(part: &Part) -> CellMesh {
    let cells = part.cells();
    cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin())
}

/// A part of cells of a millimetre, in one call: the support has surfaces of its own, beside those of the part.
#[test]
fn a_part_is_complete_in_one_call() {
    let part = hanging_ball();
    let mesh = mesh_of(&part);
    let workpiece = workpiece(&part, &mesh);
    let support_only = LayerOptions { nozzle: NozzleUse::Off, ..incremental() };
    let complete = workpiece.layers(&support_only, &go).unwrap();
    let (layered, support) = (&complete, complete.support.as_ref().unwrap());
    assert!(complete.missed_by_hull.len() > 400);
    assert!(layered.growth.missed.is_empty() && layered.growth.nozzle.is_empty());
    assert!(layered.audit.is_ok() && layered.uniform.audit.is_ok());
    assert_eq!(layered.audit.cells, part.cells().iter().count() + support.cells.len());
    assert_eq!(layered.surfaces.sheets.len(), support.surfaces.sheets.len());
    let share = layered.surfaces.spacing.volume_mm3 / workpiece.volume_mm3;
    assert!((share - 1.0).abs() < 0.05, "{share}");
    let share = support.surfaces.spacing.volume_mm3 / support.cells.len() as f64;
    assert!((share - 1.0).abs() < 0.1, "{share}");

    // What is printed of each layer: the part's triangles, then those of the support.
    let printed = support.printed_with(&layered.surfaces);
    assert_eq!(printed.len(), layered.surfaces.sheets.len());
    for ((printed, of_part), of_support) in printed.iter().zip(&layered.surfaces.sheets).zip(&support.surfaces.sheets) {
        assert_eq!(printed.part_triangles, of_part.triangles.len());
        assert_eq!(printed.triangles.len(), of_part.triangles.len() + of_support.triangles.len());
        assert_eq!(printed.thickness_mm.len(), printed.triangles.len());
        let corner = |&[a, ..]: &[u32; 3]| printed.vertices[a as usize];
        let support = printed.triangles[printed.part_triangles..].iter().zip(&of_support.triangles);
        assert!(support.into_iter().all(|(now, before)| corner(now) == of_support.vertices[before[0] as usize]));
    }

    // With a gap: those of its cells have no surfaces.
    let gap = SupportOptions { gap: 2, ..SupportOptions::default() };
    let options = LayerOptions { support: Some(gap), ..support_only };
    let with_gap = workpiece.layers(&options, &go).unwrap();
    let short = with_gap.support.unwrap();
    assert_eq!((short.cells.len(), short.gap.len()), (support.cells.len() - 10, 10));
    assert!(with_gap.audit.is_ok());
    let top = |support: &PartSupport| {
        let points = support.surfaces.sheets.iter().flat_map(|sheet| &sheet.vertices);
        points.fold(0.0, |top: f64, point| top.max(point.z))
    };
    assert!(top(support) > 6.0 && top(&short) < 5.0 + 1e-9, "{} {}", top(support), top(&short));

    // With the nozzle alone: no support, and cells that are printed from the side.
    let rule = NozzleRule { cone_height_mm: 3.0, block_mm: 8.0, ..tip_1_mm() };
    let nozzle_only = LayerOptions { rule, support: None, ..incremental() };
    let complete = workpiece.layers(&nozzle_only, &go).unwrap();
    assert!(complete.support.is_none() && complete.growth.nozzle.len() > 400);
    assert!(complete.audit.is_ok() && complete.uniform.audit.is_ok());

    // With neither it is the order by hulls, and the surfaces of its field.
    let neither = LayerOptions { nozzle: NozzleUse::Off, support: None, ..incremental() };
    let complete = workpiece.layers(&neither, &go).unwrap();
    let Workpiece { cells, platform, rules, .. } = &workpiece;
    let growth = Strategy::Incremental.grow(cells, platform, rules, &go).unwrap();
    assert_eq!(complete.growth, growth);
    let missed = growth.missed_cells();
    let uniform = uniform_field(cells, platform, rules, &growth.order, &missed, &go).unwrap();
    assert_eq!(complete.surfaces, workpiece.surfaces(&uniform.field, &missed, 1.0, &go).unwrap());

    let rule = NozzleRule { max_tilt: 0.0, ..NozzleRule::default() };
    let error = workpiece.layers(&LayerOptions { rule, strategy: None, ..incremental() }, &go);
    let tilt = GrowthError::Nozzle(NozzleRuleError::Tilt { max_tilt: 0.0 });
    assert_eq!(error.unwrap_err(), LayersError::Growth(tilt));
    let support = Some(SupportOptions { width: 0, ..SupportOptions::default() });
    let options = LayerOptions { nozzle: NozzleUse::Off, support, ..incremental() };
    let error = workpiece.layers(&options, &go).unwrap_err();
    assert_eq!(error, LayersError::Support(SupportError::Width { width: 0 }));
    let stop = |p: Progress| if p.stage == "support" { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let error = workpiece.layers(&support_only, &stop).unwrap_err();
    assert_eq!(error, LayersError::Cancelled);
}

/// Where cells are missed and there is no support, it says why, and what to do.
#[test]
fn missed_cells_without_support_come_with_the_reason() {
    let ball = hanging_ball();
    // What hangs from a beam hangs so far beside the plate that no column leans back to it.
    let mut beside = part([1, 16, 21], |[_, y, z]| y == 0 || z == 20 || (y == 6 && z > 1));
    beside.platform = Platform::polygon(&[[-20.0, 0.0], [21.0, 0.0], [21.0, 1.0], [-20.0, 1.0]]).unwrap();
    let tower = part([3, 3, 4], |_| true);
    let allowed = Some(SupportOptions::default());
    let no_rounds = Some(SupportOptions { rounds: 0, ..SupportOptions::default() });
    for (part, strategy, support, why) in [
        (&ball, Strategy::Incremental, None, Some(NoSupport::Forbidden)),
        (&ball, Strategy::Incremental, no_rounds, Some(NoSupport::Forbidden)),
        (&ball, Strategy::Incremental, allowed, None),
        (&beside, Strategy::Greedy, allowed, Some(NoSupport::NoPlace)),
        (&tower, Strategy::Greedy, None, None),
    ] {
        let mesh = mesh_of(part);
        let workpiece = workpiece(part, &mesh);
        let options = LayerOptions { nozzle: NozzleUse::Off, support, ..incremental() };
        let order = workpiece.order(&LayerOptions { strategy: Some(strategy), ..options }, &go).unwrap();
        assert_eq!(order.no_support, why);
        assert_eq!(why.is_some(), !order.final_growth().missed.is_empty());
        assert!(why.is_none_or(|why| order.supported.is_none() && why.to_string().contains("turn the part")));
        let made = workpiece.layers_of(order, &options, &go).unwrap();
        assert_eq!((made.no_support, made.support.is_none()), (why, support.is_none() || why.is_some()));
    }
}

/// Columns that help nobody: grown with them, the part misses what it missed before.
#[test]
fn support_that_does_not_help_says_so() {
    let (part, rules) = (hanging_ball(), Rules::default());
    let growth = Strategy::Incremental.grow(&part.cells(), &part.platform, &rules, &go).unwrap();
    let same = |_: &Cells| Ok(growth.clone());
    let tried =
        add_support(&part.cells(), &part.platform, &rules, &growth, &[], &SupportOptions::default(), &same, &go);
    assert_eq!(tried.unwrap(), Err(NoSupport::NoHelp));
}

/// Coherent layers of a part with its support, of one without, and of one with cells that the nozzle builds.
#[test]
fn coherent_layers_are_those_of_part_and_support() {
    let (ball, mut taken) = (hanging_ball(), Vec::new());
    let rule = NozzleRule { cone_height_mm: 3.0, block_mm: 8.0, ..tip_1_mm() };
    let support_only = LayerOptions { nozzle: NozzleUse::Off, ..incremental() };
    let neither = LayerOptions { support: None, ..support_only };
    let by_nozzle = LayerOptions { rule, support: None, ..incremental() };
    let mesh = mesh_of(&ball);
    let workpiece = workpiece(&ball, &mesh);
    for options in [support_only, neither, by_nozzle] {
        let order = workpiece.order(&options, &go).unwrap();
        let even = workpiece.layers_of(order.clone(), &options, &go).unwrap();
        let made = workpiece.layers_of(order, &LayerOptions { coherent: true, ..options }, &go).unwrap();
        assert_eq!(made.growth, even.growth);
        let [waits, waits_of_even] = [&made, &even].map(|made| made.surfaces.boundary.at_waits_mm);
        if made.uniform.method == UniformMethod::Coherent {
            taken.push(options);
            assert!(made.growth.nozzle.is_empty() && waits < waits_of_even, "{waits} {waits_of_even}");
            assert!(made.uniform.audit.is_ok());
            assert_eq!(made.uniform.audit.cells, even.audit.cells);
        } else {
            assert_eq!(made.surfaces, even.surfaces);
        }
        let [support, support_of_even] = [&made, &even].map(|made| made.support.as_ref());
        assert_eq!(support.is_some(), support_of_even.is_some());
        if let (Some(support), Some(of_even)) = (support, support_of_even) {
            assert_eq!((&support.cells, support.straight_cells), (&of_even.cells, of_even.straight_cells));
            assert_eq!(support.surfaces.sheets.len(), made.surfaces.sheets.len());
            let share = support.surfaces.spacing.volume_mm3 / support.cells.len() as f64;
            assert!((share - 1.0).abs() < 0.1, "{share}");
        }
        if options == neither {
            let alone = workpiece.layers(&LayerOptions { coherent: true, ..neither }, &go).unwrap();
            assert_eq!((&made.surfaces, made.uniform.method), (&alone.surfaces, alone.uniform.method));
        }
    }
    assert!(taken.contains(&support_only), "{taken:?}");
}

/// From the start on each cell is built by either rule, and the audit agrees.
#[test]
fn from_the_start_on_both_rules_count() {
    let part = hanging_ball();
    let mesh = mesh_of(&part);
    let workpiece = workpiece(&part, &mesh);
    let rule = NozzleRule { cone_height_mm: 3.0, block_mm: 8.0, ..tip_1_mm() };
    let options = LayerOptions { nozzle: NozzleUse::FromStart, rule, support: None, ..incremental() };
    let complete = workpiece.layers(&options, &go).unwrap();
    let growth = &complete.growth;
    assert!(complete.audit.is_ok() && complete.uniform.audit.is_ok());
    assert!(10 * growth.missed.len() < complete.missed_by_hull.len(), "{}", growth.missed.len());
    assert!(growth.nozzle.len() < part.cells().iter().count()); // the hull rule suffices for many
}

/// A mast with a level arm.
fn arm() -> Part {
    part([9, 3, 9], |[x, _, z]| x == 0 || z >= 7)
}

/// Cells that are given hold support though none is missed: those outside of the part, and those of the part beside its material. With a gap none touch it.
#[test]
fn given_cells_hold_support() {
    let (part, rules) = (arm(), Rules::default());
    let cells = part.cells();
    let growth = grown(&part, &cells, &rules).unwrap();
    assert!(growth.missed.is_empty());
    let again = |cells: &Cells| grown(&part, cells, &rules);
    let with = |given: &[u32], gap: u32| {
        let options = SupportOptions { gap, ..SupportOptions::default() };
        add_support(&cells, &part.platform, &rules, &growth, given, &options, &again, &go)
    };
    let column: Vec<u32> = (0..7).map(|z| cells.id([4, 1, z])).collect();
    let touching = cells.id([4, 1, 7]);
    let given = [&column[..], &[touching]].concat();
    let supported = with(&given, 0).unwrap().unwrap();
    assert_eq!((supported.support, supported.contact, supported.gap), (column.clone(), vec![touching], vec![]));
    assert_eq!((supported.straight_cells, supported.growth.missed.len(), supported.rounds), (7, 0, 1));

    let supported = with(&given, 2).unwrap().unwrap();
    let (support, gap) = (column[..5].to_vec(), column[5..].to_vec());
    assert_eq!((supported.support, supported.contact, supported.gap), (support, vec![], gap));

    // What nothing carries is left out; a cell beyond the grid is refused.
    let floating = cells.id([6, 1, 3]);
    let supported = with(&[&column[..], &[floating]].concat(), 0).unwrap().unwrap();
    assert_eq!(supported.support, column);
    assert_eq!(with(&[999], 0), Err(SupportError::Growth(GrowthError::OtherCells { cell: 999 })));
    assert_eq!(with(&[], 0), Ok(Err(NoSupport::NotNeeded)));
}

/// Bug: a cell that was missed all the same held support, and a field that was saved with it could not be read again.
#[test]
fn a_missed_cell_holds_no_support() {
    let floats = |[x, y, z]: [u32; 3]| x == 8 && y == 1 && z == 3;
    let part = part([9, 3, 9], |at| at[0] == 0 || at[2] >= 7 || floats(at));
    let (cells, rules) = (part.cells(), Rules::default());
    let floating = cells.id([8, 1, 3]);
    let growth = grown(&part, &cells, &rules).unwrap();
    assert_eq!(growth.missed_cells(), [floating]);
    let again = |cells: &Cells| grown(&part, cells, &rules);
    // No round places a column below it, only what is given.
    let options = SupportOptions { rounds: 1, ..SupportOptions::default() };
    let given = [floating, cells.id([4, 1, 7])];
    let grow = |united: &Cells| {
        let mut growth = again(united)?;
        growth.missed.retain(|missed| missed.cell != floating);
        growth.missed.push(MissedCell { cell: floating, reason: MissedReason::OutOfReach });
        Ok(growth)
    };
    let found = add_support(&cells, &part.platform, &rules, &growth, &given, &options, &grow, &go).unwrap().unwrap();
    assert_eq!(found.growth.missed_cells(), [floating]);
    assert_eq!(found.contact, given[1..]);
}

/// Columns go straight down from where the part ends to where it begins again, and so do those around. Places with more of the part below them have none.
#[test]
fn columns_below_places() {
    let part = arm();
    let mesh = mesh_of(&part);
    let below_in =
        |part: &Part, mesh: &CellMesh, at: [f64; 3]| workpiece(part, mesh).cells_below(&[Point3::from(at)]).unwrap();
    let cells = part.cells();
    let below = |at: [f64; 3]| below_in(&part, &mesh, at);
    let block = |xs: std::ops::Range<u32>, zs: std::ops::Range<u32>| -> Vec<u32> {
        let [xs, zs] = [&xs, &zs].map(|range| range.clone().collect::<Vec<u32>>());
        let rows = zs.iter().flat_map(|&z| (0..3).map(move |y| [y, z]));
        rows.flat_map(|[y, z]| xs.iter().map(move |&x| [x, y, z])).map(|at| cells.id(at)).collect()
    };
    for z in [7.5, 8.5, 6.9] {
        assert_eq!(below([4.5, 1.5, z]), block(3..6, 0..7), "{z}");
    }
    assert_eq!(below([1.5, 1.5, 7.5]), block(1..3, 0..7)); // beside the mast
    assert_eq!(below([8.5, 1.5, 7.5]), block(7..9, 0..7)); // at the end
    assert_eq!(below([4.5, 1.5, 3.2]), block(3..6, 0..4)); // in the air
    for outside in [[-0.5, 1.5, 7.5], [4.5, 1.5, 20.0], [4.5, f64::NAN, 7.5]] {
        assert!(below(outside).is_empty());
    }
    assert!(workpiece(&part, &mesh).cells_below(&[]).unwrap().is_empty());
    // A block is solid; over a step the column ends in the cell in which that begins.
    let whole = self::part([9, 9, 9], |_| true);
    assert!(below_in(&whole, &mesh_of(&whole), [4.5, 4.5, 5.5]).is_empty());
    let step = self::part([9, 3, 9], |[x, _, z]| x == 0 || !(2..7).contains(&z));
    assert_eq!(below_in(&step, &mesh_of(&step), [4.5, 1.5, 7.5]), block(3..6, 1..7));
}

/// A beam whose lower side rises from the plate to less than a cell over it: support fills the wedge below, and ends at the mesh.
#[test]
fn support_fills_what_is_below_the_part_in_its_own_cells() {
    let block = part([12, 6, 4], |_| true);
    // From x = 4 on the lower side rises to 0.8 mm at x = 12.
    let section = [[0.0, 0.0], [4.0, 0.0], [12.0, 0.8], [12.0, 4.0], [0.0, 4.0]];
    let vertices: Vec<Point3<f64>> =
        [0.0, 6.0].into_iter().flat_map(|y| section.map(|[x, z]| Point3::new(x, y, z))).collect();
    let sides = (0..5u32).flat_map(|k| {
        let next = (k + 1) % 5;
        [[k, next, k + 5], [next, next + 5, k + 5]]
    });
    let ends = (1..4u32).flat_map(|k| [[0, k + 1, k], [5, k + 5, k + 6]]);
    let triangles: Vec<[u32; 3]> = sides.chain(ends).map(|[a, b, c]| [a, c, b]).collect();
    let mesh = CellMesh { vertices, triangles };
    let volume_mm3 = 12.0 * 6.0 * 4.0 - 8.0 * 0.8 / 2.0 * 6.0;
    let plain = Workpiece { volume_mm3, ..workpiece(&block, &mesh) };
    let places: Vec<Point3<f64>> =
        (0..6).flat_map(|y| (4..12).map(move |x| Point3::new(f64::from(x) + 0.9, f64::from(y) + 0.5, 0.9))).collect();
    let under = plain.cells_below(&places).unwrap();
    let expected: Vec<u32> = (0..6).flat_map(|y| (4..12).map(move |x| x + 12 * y)).collect();
    assert_eq!(under, expected);
    let part = Workpiece { guides: Guides { support: &under, ..Guides::default() }, ..plain };
    for layers_by in [LayersBy::Distance, LayersBy::Directed] {
        let options = LayerOptions { layers_by, height_mm: Some(0.5), ..LayerOptions::default() };
        let made = part.layers(&options, &go).unwrap();
        let support = made.support.unwrap();
        assert_eq!((&support.cells[..], &support.contact), (&[][..], &under));
        // Level layers at 0.25 and 0.75 mm: together they fill the block, above it is the part alone.
        let sheets = made.surfaces.sheets.iter().zip(&support.surfaces.sheets);
        for ((of_part, of_support), height) in sheets.zip([0.25, 0.75, 1.25, 1.75]) {
            let below = if height < 0.8 { (12.0 - 4.0 - 10.0 * height) * 6.0 } else { 0.0 };
            assert!((of_support.area() - below).abs() < 1e-6, "{height}: {}", of_support.area());
            assert!((of_part.area() + of_support.area() - 72.0).abs() < 1e-6, "{height}");
        }
        // Without support they count for nothing.
        let none = LayerOptions { support: None, ..options };
        let [bare, before] = [&part, &plain].map(|part| part.layers(&none, &go).unwrap());
        assert_eq!(bare.surfaces, before.surfaces);
        assert!(bare.support.is_none() && before.support.is_none());
    }
}
