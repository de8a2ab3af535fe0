//! What printing takes: closed forms, against layers that are filled, how it scales, what is refused.

use crate::common::{go_on, grid};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::estimate::{PrintEstimate, SampledPart, Samples, estimate_print};
use curvlay_toolpath::fill::{FillLayersError, fill_layers};
use curvlay_toolpath::infill::FillError;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3};
use curvlay_toolpath::path::{InfillOptions, PathError, PathOptions, Pattern};
use curvlay_toolpath::travel::TravelOptions;
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Layers of one thickness, the mesh around them, and what they stand for.
struct Part {
    layers: Vec<SurfaceMesh>,
    thickness: Vec<Vec<f64>>,
    solid: SurfaceMesh,
    layers_each: f64,
}

impl Part {
    fn new(layers: Vec<SurfaceMesh>, height: f64) -> Part {
        let thickness = layers.iter().map(|mesh| vec![height; mesh.triangles().len()]).collect();
        let solid = layers[0].clone(); // for solid layers nobody asks
        Part { layers, thickness, solid, layers_each: 1.0 }
    }

    fn surfaces(&self) -> Vec<LayerSurface<'_>> {
        self.layers.iter().zip(&self.thickness).map(surface).collect()
    }

    fn estimated(&self, options: PathOptions) -> Result<PrintEstimate, FillLayersError> {
        let surfaces = self.surfaces();
        let solid = (self.solid.vertices(), self.solid.triangles());
        let part = SampledPart { surfaces: &surfaces, options, solid };
        let samples = Samples { parts: &[part], layers_each: self.layers_each };
        estimate_print(&samples, &DepositionOptions::default(), &TravelOptions::default(), &go_on)
    }
}

fn surface<'a>((mesh, thickness): (&'a SurfaceMesh, &'a Vec<f64>)) -> LayerSurface<'a> {
    LayerSurface::from((mesh.vertices(), mesh.triangles(), &thickness[..]))
}

fn beads(bead: f64) -> PathOptions {
    PathOptions { bead, ..PathOptions::default() }
}

/// A rectangle at a height, in triangles of about a millimetre.
fn rectangle(wide: f64, deep: f64, z: f64) -> SurfaceMesh {
    let [nx, ny] = [wide, deep].map(|side| (side.ceil() as u32).max(2));
    let at = |x: u32, y: u32| Point3::new(wide * f64::from(x) / f64::from(nx), deep * f64::from(y) / f64::from(ny), z);
    let vertices = (0..=ny).flat_map(|y| (0..=nx).map(move |x| at(x, y))).collect();
    let corner = |x: u32, y: u32| x + (nx + 1) * y;
    let two = |x, y| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..ny).flat_map(|y| (0..nx).flat_map(move |x| two(x, y))).collect();
    SurfaceMesh::new(vertices, triangles).unwrap()
}

/// A ring with these radii.
fn ring(outer: f64, inner: f64) -> SurfaceMesh {
    let (around, across) = (96_u32, 12_u32);
    let at = |step: u32, ring: u32| {
        let angle = std::f64::consts::TAU * f64::from(step) / f64::from(around);
        let radius = inner + (outer - inner) * f64::from(ring) / f64::from(across);
        Point3::new(radius * angle.cos(), radius * angle.sin(), 0.3)
    };
    let vertices = (0..=across).flat_map(|ring| (0..around).map(move |step| at(step, ring))).collect();
    let two = |step: u32, ring: u32| {
        let corner = |step: u32, ring: u32| step % around + around * ring;
        let [a, b, c, d] =
            [(step, ring), (step, ring + 1), (step + 1, ring + 1), (step + 1, ring)].map(|(s, r)| corner(s, r));
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..across).flat_map(|ring| (0..around).flat_map(move |step| two(step, ring))).collect();
    SurfaceMesh::new(vertices, triangles).unwrap()
}

/// A block of this size.
fn block(size: [f64; 3]) -> SurfaceMesh {
    let corner = |k: usize| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { size[axis] } else { 0.0 }));
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    SurfaceMesh::new((0..8).map(corner).collect(), faces.to_vec()).unwrap()
}

/// A block in layers of 0.3 mm.
fn layered(size: [f64; 2], layers: u32) -> Part {
    let height = |layer: u32| 0.3 * (f64::from(layer) + 0.5);
    let sheets = (0..layers).map(|layer| rectangle(size[0], size[1], height(layer))).collect();
    Part { solid: block([size[0], size[1], 0.3 * f64::from(layers)]), ..Part::new(sheets, 0.3) }
}

#[test]
fn beads_in_a_strip_are_as_many_and_as_wide_as_fit() {
    // Wide, and the beads across by their width: two share the strip, one fills it, one is as wide as it may be, none fits.
    for (wide, across, width) in
        [(2.0, 2.0, 1.0), (1.6, 2.0, 0.8), (4.4, 4.0, 1.1), (1.2, 1.0, 1.2), (0.6, 1.0, 0.6), (0.4, 0.0, 0.0)]
    {
        let estimate = Part::new(vec![rectangle(60.0, wide, 0.3)], 0.5).estimated(beads(1.0)).unwrap();
        let (length, volume) = (60.0 * across, 60.0 * across * width * 0.5);
        // Ends of the strip, as deep as half of it, are as narrow as corners.
        assert!((estimate.bead_mm - length).abs() <= 0.04 * length, "{wide}: {} of {length}", estimate.bead_mm);
        assert!(
            (estimate.extruded_mm3 - volume).abs() <= 0.02 * volume + 1e-9,
            "{wide}: {} of {volume}",
            estimate.extruded_mm3
        );
        let bare = if across > 0.0 { 0.0 } else { 60.0 * wide };
        assert!((estimate.too_narrow_mm2 - bare).abs() <= wide * wide, "{wide}: {}", estimate.too_narrow_mm2);
        assert!((estimate.area_mm2 - 60.0 * wide).abs() < 1e-9);
    }
}

#[test]
fn time_and_filament_are_those_of_their_rules() {
    let part = Part { layers_each: 10.0, ..Part::new(vec![rectangle(20.0, 10.0, 0.3)], 0.3) };
    let estimate = part.estimated(beads(0.5)).unwrap();
    // 20 x 10 x 3 mm: beads of 0.5 x 0.3 mm would go 53 mm/s by the flow, and go 40.
    assert!((estimate.bead_mm - 4000.0).abs() < 1.0 && (estimate.extruded_mm3 - 600.0).abs() < 0.2);
    assert!((estimate.print_s - 100.0).abs() < 0.05, "{}", estimate.print_s);
    assert!((estimate.filament_mm - estimate.extruded_mm3 / 2.405_281_875).abs() < 1e-6);
    // Ten curves, nine travels: at each 1 mm of filament back at 30 mm/s and forward at 20, and 4 mm up and down.
    assert!((estimate.curves - 10.0).abs() < 1e-12);
    let retracting = 9.0 * (1.0 / 30.0 + 1.0 / 20.0);
    assert!((estimate.travel_s - retracting - estimate.travel_mm / 80.0).abs() < 1e-9);
    // Between two places of a rectangle lie 10.4 mm in the mean, and the nearer end of the next curve is taken: some 7 mm.
    let way = estimate.travel_mm / 9.0 - 4.0;
    assert!((4.0..=10.0).contains(&way), "{way}");
    assert!((estimate.total_s() - estimate.print_s - estimate.travel_s).abs() < 1e-12);
}

/// Estimates are of what is laid: within so many percent of curves that are found.
#[test]
fn lengths_are_near_those_of_curves() {
    let flat = |p: Point2<f64>| Point3::new(p.x, p.y, 0.3);
    let with_holes = |n| grid(n, 7, 0.3, |x, y| (4..7).contains(&x) && (3..9).contains(&y), flat);
    let curved =
        |_: usize| grid(14, 5, 0.4, |_, _| false, |p| Point3::new(p.x, p.y, 0.03 * p.x * p.x + 0.4 * p.y.sin()));
    let shapes: [(&str, SurfaceMesh); 5] = [
        ("square", rectangle(15.0, 15.0, 0.3)),
        ("wall", rectangle(30.0, 2.3, 0.3)),
        ("with a hole", with_holes(14)),
        ("ring", ring(12.0, 5.0)),
        ("curved", curved(0)),
    ];
    for (name, mesh) in shapes {
        for bead in [0.4, 0.7, 1.0] {
            let part = Part::new(vec![mesh.clone()], 0.3);
            let estimate = part.estimated(beads(bead)).unwrap();
            let filled = fill_layers(&part.surfaces(), &beads(bead), &go_on).unwrap();
            let found = filled.totals().path_mm;
            assert!((estimate.bead_mm / found - 1.0).abs() < 0.06, "{name} {bead}: {} of {found}", estimate.bead_mm);
        }
    }
}

#[test]
fn walls_skins_and_infill_are_those_of_layers_that_are_filled() {
    let part = layered([24.0, 18.0], 24);
    for (density, walls, skin) in [(0.2, 2, 3), (0.4, 3, 4), (0.0, 2, 3), (0.25, 1, 0)] {
        let infill = InfillOptions { density, walls, skin, ..InfillOptions::default() };
        let options = PathOptions { infill, ..beads(0.5) };
        let estimate = part.estimated(options).unwrap();
        let totals = fill_layers(&part.surfaces(), &options, &go_on).unwrap().totals();
        let near = |found: f64, wanted: f64| (found - wanted).abs() <= 0.05 * wanted + 1e-9;
        assert!(near(estimate.bead_mm, totals.path_mm), "{density}: {} of {}", estimate.bead_mm, totals.path_mm);
        assert!(
            near(estimate.sparse_mm3, totals.sparse.volume_mm3),
            "{density}: {} of {}",
            estimate.sparse_mm3,
            totals.sparse.volume_mm3
        );
        let infill_mm = totals.sparse.infill_mm;
        assert!(
            (estimate.infill_mm - infill_mm).abs() <= 0.1 * infill_mm + 1e-9,
            "{density}: {} of {infill_mm}",
            estimate.infill_mm
        );
    }
}

#[test]
fn twice_the_density_is_twice_the_infill() {
    let part = layered([24.0, 18.0], 12);
    let estimate = |density| {
        let infill = InfillOptions { density, walls: 2, skin: 2, ..InfillOptions::default() };
        part.estimated(PathOptions { infill, ..beads(0.5) }).unwrap()
    };
    let [thin, dense] = [0.2, 0.4].map(estimate);
    assert!((dense.infill_mm - 2.0 * thin.infill_mm).abs() < 1e-9 * dense.infill_mm && thin.infill_mm > 0.0);
    assert!((dense.bead_mm - thin.bead_mm - thin.infill_mm).abs() < 1e-6);
    assert!((dense.sparse_mm3 - thin.sparse_mm3).abs() < 1e-9 * thin.sparse_mm3);
}

#[test]
fn rings_that_are_not_joined_are_curves_of_their_own() {
    let part = Part::new(vec![rectangle(12.0, 12.0, 0.3)], 0.3);
    let curves = |pattern| part.estimated(PathOptions { pattern, ..beads(1.0) }).unwrap().curves;
    let found = [Pattern::Spirals, Pattern::Zigzag, Pattern::Rings].map(curves);
    assert!(found.iter().zip([1.0, 1.0, 6.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{found:?}");
}

#[test]
fn regions_far_apart_take_a_way_between_them() {
    let far = |x: f64| {
        rectangle(4.0, 4.0, 0.3).vertices().iter().map(|p| p + Point3::new(x, 0.0, 0.0).coords).collect::<Vec<_>>()
    };
    let one = rectangle(4.0, 4.0, 0.3);
    let count = one.vertices().len() as u32;
    let triangles: Vec<_> =
        one.triangles().iter().copied().chain(one.triangles().iter().map(|t| t.map(|v| v + count))).collect();
    let two = SurfaceMesh::new([far(0.0), far(100.0)].concat(), triangles).unwrap();
    let estimate = Part { layers_each: 5.0, ..Part::new(vec![two], 0.3) }.estimated(beads(0.5)).unwrap();
    // To and fro: each layer begins where the last one ended. Nine travels, five of them across.
    assert!((estimate.curves - 10.0).abs() < 1e-12);
    assert!((estimate.travel_mm - 9.0 * 4.0 - 5.0 * 100.0).abs() < 60.0, "{}", estimate.travel_mm);
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let part = Part::new(vec![rectangle(4.0, 4.0, 0.3)], 0.3);
    for bead in [0.0, -1.0, f64::NAN] {
        let error = part.estimated(beads(bead)).unwrap_err();
        assert!(
            matches!(error, FillLayersError::Layer { layer: 0, error: FillError::Paths(PathError::Bead { .. }) }),
            "{error}"
        );
    }
    let torn = [[0, 1, 2], [0, 1, 3], [0, 1, 4]];
    let vertices = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0]].map(|[x, y]| Point3::new(x, y, x * y));
    let surface = LayerSurface::from((&vertices[..], &torn[..], &[0.3; 3][..]));
    let part = SampledPart { surfaces: &[surface], options: beads(0.5), solid: (&[], &[]) };
    let samples = Samples { parts: &[part], layers_each: 1.0 };
    let (deposition, travel) = (DepositionOptions::default(), TravelOptions::default());
    let error = estimate_print(&samples, &deposition, &travel, &go_on).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { layer: 0, error: FillError::Mesh(_) }), "{error}");
    let sound = rectangle(4.0, 4.0, 0.3);
    let thickness = vec![0.3; sound.triangles().len()];
    let surface = LayerSurface::from((sound.vertices(), sound.triangles(), &thickness[..]));
    let samples = Samples { parts: &[SampledPart { surfaces: &[surface], ..part }], layers_each: 1.0 };
    let stopped = estimate_print(&samples, &deposition, &travel, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(FillLayersError::Cancelled));
}

#[test]
fn nothing_takes_nothing() {
    let empty = LayerSurface { vertices: &[], triangles: &[], thickness: &[], is_half: false };
    let part = SampledPart { surfaces: &[empty], options: beads(0.5), solid: (&[], &[]) };
    let (deposition, travel) = (DepositionOptions::default(), TravelOptions::default());
    for parts in [&[part][..], &[]] {
        let samples = Samples { parts, layers_each: 3.0 };
        assert_eq!(estimate_print(&samples, &deposition, &travel, &go_on), Ok(PrintEstimate::default()));
    }
    // A surface without a boundary has no rings: as where it is filled.
    let error = Part::new(vec![block([4.0; 3])], 0.3).estimated(beads(0.5)).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { error: FillError::Distance(_), .. }), "{error}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let infill = InfillOptions { density: 0.3, walls: 2, skin: 2, ..InfillOptions::default() };
    let options = PathOptions { infill, ..beads(0.5) };
    let part = layered([13.0, 9.0], 9);
    let on = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| part.estimated(options).unwrap())
    };
    assert_eq!(on(1), on(4));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn estimates_scale_as_they_must(n in 6_usize..12, seed in 0_u64..50, bead in 0.3..1.2, power in -3_i32..4) {
        let mesh = grid(n, seed, 0.4, |x, y| x == 2 && y == 3, |p| Point3::new(p.x, p.y, 0.05 * p.x * p.y));
        let part = Part::new(vec![mesh.clone()], 0.3);
        let estimate = part.estimated(beads(bead)).unwrap();
        // Layers half as high are twice as many: twice the length, the same volume.
        let fine = Part { layers_each: 2.0, ..Part::new(vec![mesh.clone()], 0.15) }.estimated(beads(bead)).unwrap();
        prop_assert!((fine.bead_mm - 2.0 * estimate.bead_mm).abs() <= 1e-9 * fine.bead_mm);
        prop_assert!((fine.extruded_mm3 - estimate.extruded_mm3).abs() <= 1e-9 * estimate.extruded_mm3);
        prop_assert!((fine.curves - 2.0 * estimate.curves).abs() < 1e-9);
        // A larger part with wider beads: lengths grow as it does, volumes as its cube. By powers of two, so that nothing is rounded: whether
        // one bead more fits is decided in places by the last digit.
        let scale = 2.0_f64.powi(power);
        let vertices = mesh.vertices().iter().map(|p| p * scale).collect();
        let larger = SurfaceMesh::new(vertices, mesh.triangles().to_vec()).unwrap();
        let larger = Part::new(vec![larger], 0.3 * scale).estimated(beads(bead * scale)).unwrap();
        let by = larger.bead_mm / estimate.bead_mm / scale;
        prop_assert!((by - 1.0).abs() < 1e-3, "{by}");
        prop_assert!((larger.extruded_mm3 / estimate.extruded_mm3 / scale.powi(3) - 1.0).abs() < 1e-3);
        // No bead covers more than there is, and none takes longer than by the flow or the feed.
        prop_assert!(estimate.extruded_mm3 <= 0.3 * estimate.area_mm2 * (1.0 + 1e-9));
        let least = (estimate.extruded_mm3 / 8.0).max(estimate.bead_mm / 40.0);
        prop_assert!(estimate.print_s >= least * (1.0 - 1e-9) && estimate.print_s <= estimate.bead_mm / 2.0);
    }
}
