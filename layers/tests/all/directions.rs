//! Layers that follow directions: those given at places, and those that the overhang of the skin asks for.

use crate::common::{BOX, go, tip_1_mm};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    DirectedOptions, DirectionAt, DirectionsError, DistanceOrder, GrowthError, Guides, Platform, Rules, Workpiece,
    grow_directed,
};
use curvlay_layers::nalgebra::{Point3, Vector3};

/// A bar of cells of a millimetre that leans along x; its mesh is a sheared box.
struct Bar {
    dims: [u32; 3],
    rows: Vec<u64>,
    vertices: Vec<Point3<f64>>,
    platform: Platform,
}

impl Bar {
    /// `size` upright, and what it moves along x for each millimetre of height.
    fn new(size: [u32; 3], shear: f64) -> Bar {
        let [width, depth, height] = size;
        let nx = width + (shear * f64::from(height)).ceil() as u32;
        // The cells that the box goes through: rows hold those between its lowest and highest place in a level.
        let row = |z: u32| {
            let ends = [f64::from(z), f64::from(z + 1)].map(|z| shear * z);
            let (low, high) = (ends[0].floor() as u32, (ends[1] + f64::from(width)).ceil() as u32);
            (low..high.min(nx)).map(|x| 1u64 << x).sum::<u64>()
        };
        let rows: Vec<u64> = (0..height).flat_map(|z| (0..depth).map(move |_| row(z))).collect();
        let dims = [nx, depth, height];
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            let [x, y, z] = [x * f64::from(width), y * f64::from(depth), z * f64::from(height)];
            Point3::new(x + shear * z, y, z)
        };
        let platform = Platform::under(&Cells::new(dims, &rows).unwrap(), 60.0).unwrap();
        Bar { dims, rows, vertices: (0..8).map(corner).collect(), platform }
    }

    fn cells(&self) -> Cells<'_> {
        Cells::new(self.dims, &self.rows).unwrap()
    }

    fn workpiece(&self) -> Workpiece<'_> {
        Workpiece {
            vertices: &self.vertices,
            triangles: &BOX,
            cells: self.cells(),
            cell_mm: 1.0,
            origin: Point3::origin(),
            platform: &self.platform,
            rules: Rules::default(),
            volume_mm3: 1.0,
            guides: Guides::default(),
        }
    }

    fn grown(&self, given: &[Vector3<f64>], max_tilt: Option<f64>) -> Result<DistanceOrder, GrowthError> {
        let (nozzle, options) = (tip_1_mm(), DirectedOptions { max_tilt });
        grow_directed(&self.cells(), 1.0, &self.platform, &Rules::default(), None, &nozzle, Some(given), &options, &go)
    }
}

/// The slope of an order's field at a cell.
fn slope(bar: &Bar, made: &DistanceOrder, [x, y, z]: [u32; 3]) -> Vector3<f64> {
    let value = |x, y, z| made.field.value(bar.cells().id([x, y, z])).unwrap();
    let along = [value(x + 1, y, z) - value(x - 1, y, z), value(x, y + 1, z) - value(x, y - 1, z)];
    Vector3::new(along[0], along[1], value(x, y, z + 1) - value(x, y, z - 1)) / 2.0
}

/// One direction in an upright mast is that of all of it: its layers lie across it above the foot, as thick as layers are; no farther leaning than they may.
#[test]
fn a_mast_follows_a_direction() {
    let mast = Bar::new([8, 8, 40], 0.0);
    for (degrees, max_tilt, leans) in [(25.0, None, 25.0), (70.0, None, 39.0), (70.0, Some(0.5), 28.6)] {
        let (tilt, turn) = (f64::to_radians(degrees), 0.6_f64);
        let direction = 3.0 * Vector3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos());
        let at = [DirectionAt { place: Point3::new(4.2, 3.3, 20.1), direction }];
        let given = mast.workpiece().directions_at(&at).unwrap();
        assert_eq!(given.outside, 0);
        let made = mast.grown(&given.directions, max_tilt).unwrap();
        assert!(made.growth.missed.is_empty());
        for z in [20, 30] {
            let slope = slope(&mast, &made, [4, 4, z]);
            let [leaning, side] = [slope.xy().norm().atan2(slope.z), slope.y.atan2(slope.x)];
            assert!((leaning.to_degrees() - leans).abs() < 1.0 && (side - turn).abs() < 0.02, "{slope}");
            assert!((slope.norm() - 1.0).abs() < 0.02, "{slope}");
        }
    }
}

/// Of two places in a mast each has its half, and where they meet layers turn over some ten cells.
#[test]
fn the_nearest_direction_holds() {
    let mast = Bar::new([8, 8, 60], 0.0);
    let at = |z: f64, degrees: f64| {
        let tilt = degrees.to_radians();
        DirectionAt { place: Point3::new(4.5, 4.5, z), direction: Vector3::new(tilt.sin(), 0.0, tilt.cos()) }
    };
    let given = mast.workpiece().directions_at(&[at(20.5, 24.0), at(50.5, -12.0)]).unwrap();
    let made = mast.grown(&given.directions, None).unwrap();
    let leans = |z: u32| {
        let slope = slope(&mast, &made, [4, 4, z]);
        slope.x.atan2(slope.z).to_degrees()
    };
    for (z, degrees) in [(16, 24.0), (22, 24.0), (48, -12.0), (54, -12.0)] {
        assert!((leans(z) - degrees).abs() < 2.0, "{z}: {}", leans(z));
    }
    assert!(
        (30..42).all(|z| (2.0..6.0).contains(&(leans(z - 1) - leans(z + 1)))),
        "{:?}",
        (28..44).map(leans).collect::<Vec<f64>>()
    );
}

/// A bar that leans by 50 degrees: its underside hangs over by 30 at most if directions lean by 20, and so they do, but near the plate where the fit holds them.
/// Within 50 degrees nothing is turned.
#[test]
fn skin_hangs_over_by_no_more_than_asked_for() {
    let lean = 50_f64.to_radians();
    let bar = Bar::new([8, 6, 36], lean.tan());
    let underside = Vector3::new(lean.cos(), 0.0, -lean.sin());
    let dips = |direction: &Vector3<f64>| -direction.normalize().dot(&underside).asin().to_degrees();
    for (asked, turned) in [(30.0, 20.0), (40.0, 10.0), (51.0, 0.0)] {
        let directions = bar.workpiece().upright_directions(f64::to_radians(asked)).unwrap();
        let mut on_underside = 0;
        for cell in bar.cells().iter() {
            let [x, y, z] = bar.cells().position(cell);
            let direction = directions[cell as usize];
            if !bar.cells().contains([x + 1, y, z]) {
                on_underside += 1;
                // Cells that the skin only grazes follow those beside them.
                assert!(dips(&direction) <= f64::min(asked, 50.0) + 0.1, "{x} {y} {z}: {direction}");
            }
            // In the middle nothing draws them any other way.
            if (12..28).contains(&z) {
                let leaning = direction.x.atan2(direction.z).to_degrees();
                assert!((leaning - turned).abs() < 0.15 * turned + 1e-6, "{x} {y} {z}: {leaning}");
            }
        }
        assert!(on_underside > 6 * 30);
        let made = bar.grown(&directions, None).unwrap();
        assert!(made.growth.missed.is_empty());
        let at = [24, 3, 18];
        let leaning = slope(&bar, &made, at);
        assert!((leaning.x.atan2(leaning.z).to_degrees() - turned).abs() < 3.0, "{asked}: {leaning}");
    }
}

/// What cannot be used is refused, with the reason.
#[test]
fn unsound_directions_are_refused() {
    let mast = Bar::new([4, 4, 8], 0.0);
    let part = mast.workpiece();
    let at = |x: f64, direction| DirectionAt { place: Point3::new(x, 1.0, 1.0), direction };
    let fine = at(1.0, Vector3::z());
    for bad in [at(1.0, Vector3::zeros()), at(f64::NAN, Vector3::z()), at(1.0, Vector3::new(0.0, f64::INFINITY, 1.0))] {
        assert_eq!(part.directions_at(&[fine, bad]), Err(DirectionsError::NoDirection { index: 1 }));
    }
    assert_eq!(part.directions_at(&[at(-1.0, Vector3::z()); 3]), Err(DirectionsError::NoneInside { places: 3 }));
    assert_eq!(part.directions_at(&[]), Err(DirectionsError::NoneInside { places: 0 }));
    // Opposite ones cancel out.
    let none = part.directions_at(&[fine, at(1.1, -Vector3::z())]).unwrap();
    assert_eq!(none.directions[mast.cells().id([1, 1, 1]) as usize], Vector3::zeros());
    for angle in [0.0, -0.1, std::f64::consts::FRAC_PI_2, f64::NAN] {
        let refused = part.upright_directions(angle);
        assert!(
            matches!(refused, Err(DirectionsError::Overhang { angle: reported }) if reported.to_bits() == angle.to_bits())
        );
    }
    let given = part.directions_at(&[fine]).unwrap().directions;
    assert_eq!(mast.grown(&given[1..], None), Err(GrowthError::Directions { len: given.len() }));
    let mut unsound = given.clone();
    unsound[7].y = f64::NAN;
    assert_eq!(mast.grown(&unsound, None), Err(GrowthError::Directions { len: given.len() }));
    assert_eq!(mast.grown(&given, None).unwrap().growth.missed, []);
}
