//! The test of the arcs (section 5.4.2) by the solver: stiffness with tapes that follow the arc, with tapes in planar layers and without, and the load at which
//! layers come apart.
//!
//! Cells belong to the arc by their centres, so that its volume is right in the mean. Its lower edges stand on a table, one of them slides, and its crown is
//! pressed. Loads are small: the arch of the theory stays as it is, while the real ones were bent flat and beyond.

use super::planar::Planar;
use super::specimens::{CROWN_MM, Specimen};
use super::tapes::Planned;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_layers::cells::Cells;
use curvlay_layers::elastic::{
    Bond, Elastic, ElasticOptions, ElasticPart, Load, Material, Orthotropic, Ply, Region, Strip, Support, load_factor,
    plies, solve_composite,
};
use curvlay_toolpath::fiber::tapes::Tape;

/// Edge of the cells in millimetres: two in a layer of 0.6 mm.
const CELL_MM: f64 = 0.3;
/// The force of the test, in N; all that is asked for are ratios to it.
const FORCE_N: f64 = 1.0;
/// Length of the crown that is pressed, in millimetres: a sharp edge.
const PRESSED_MM: f64 = 1.2;
/// Near the edge and the ends bonds are not judged: cells there feel how the load is put on, in millimetres.
const FREE_MM: f64 = 4.2;
/// Share of the bonds' area that has come apart where a specimen counts as delaminated.
pub const APART: f64 = 0.01;

/// What the solver finds of one arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcTest {
    /// Force per sinking of the crown in N/mm.
    pub stiffness_n_mm: f64,
    /// Force in N at which the bonds come apart, for a bond of 1 MPa in peel and in shear.
    pub apart_n_mpa: f64,
    /// Volume of its tapes in cubic millimetres.
    pub tape_mm3: f64,
}

/// The arcs of the test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arcs {
    /// Planar layers without tapes, PU.
    pub planar: ArcTest,
    /// Planar layers with tapes where they have room; not in the dissertation.
    pub planar_taped: ArcTest,
    /// Curved layers without tapes, CU.
    pub curved: ArcTest,
    /// Curved layers with tapes, CR.
    pub curved_taped: ArcTest,
}

/// The arc as cells.
struct ArcCells {
    dims: [u32; 3],
    rows: Vec<u64>,
    origin: Point3<f64>,
    specimen: Specimen,
}

impl ArcCells {
    fn new(specimen: &Specimen) -> Option<Self> {
        let (_, half) = specimen.arc()?;
        let [low, high] = specimen.solid().bounds()?;
        let margin = Vector3::repeat(0.5 * CELL_MM);
        let (origin, size) = (low - margin, high - low + 2.0 * margin);
        let dims = [size.x, size.y, size.z].map(|edge| (edge / CELL_MM).ceil() as u32);
        let words = dims[0].div_ceil(64) as usize;
        let mut arc =
            ArcCells { dims, rows: vec![0; words * (dims[1] * dims[2]) as usize], origin, specimen: *specimen };
        let [width, height] = specimen.section_mm();
        for (z, y, x) in (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| (z, y, x))))
        {
            let at = arc.centre([x, y, z]);
            let up = arc.up(&at);
            let is_in = (0.0..=height).contains(&specimen.height(at)) && at.y.abs() <= width / 2.0;
            if is_in && up.x.atan2(up.z).abs() <= half {
                arc.rows[(y + dims[1] * z) as usize * words + x as usize / 64] |= 1 << (x % 64);
            }
        }
        Some(arc)
    }

    fn centre(&self, cell: [u32; 3]) -> Point3<f64> {
        self.origin + Vector3::from(cell.map(|k| (f64::from(k) + 0.5) * CELL_MM))
    }

    /// Away from the axis of the arc.
    fn up(&self, at: &Point3<f64>) -> Vector3<f64> {
        let along = self.specimen.along(*at);
        Vector3::new(-along.z, 0.0, along.x).normalize()
    }

    fn region(&self, low: [f64; 3], high: [f64; 3]) -> Region {
        let inside = |corner: [f64; 3]| [0, 1, 2].map(|k| corner[k] - self.origin[k]);
        Region { low_mm: inside(low), high_mm: inside(high) }
    }

    /// The lines on which the arc stands: hinges, each a row of nodes across.
    fn feet(&self, cells: &Cells) -> [Region; 2] {
        let places = || cells.iter().map(|cell| cells.position(cell));
        let floor = places().map(|[.., z]| z).min().unwrap_or(0);
        let lowest = || places().filter(|[.., z]| *z == floor).map(|[x, ..]| x);
        let line = |x: u32| {
            let [x, z] = [x, floor].map(|k| f64::from(k) * CELL_MM);
            let slack = 0.25 * CELL_MM;
            Region { low_mm: [x - slack, f64::NEG_INFINITY, z - slack], high_mm: [x + slack, f64::INFINITY, z + slack] }
        };
        // The inner edges of the ends: between them is air.
        let (first, last) = (lowest().min().unwrap_or(0), lowest().max().unwrap_or(0) + 1);
        let inner = |x: u32| lowest().any(|other| other == x);
        let left = (first..).find(|&x| !inner(x)).unwrap_or(first);
        let right = (0..last).rev().find(|&x| !inner(x)).map_or(last, |x| x + 1);
        [line(left), line(right)]
    }

    /// Presses the arc.
    ///
    /// * `normal`: across the layers at a place.
    fn test(
        &self,
        material: Material,
        (tape, strips): (&Orthotropic, &[Strip]),
        normal: &dyn Fn(&Point3<f64>) -> Vector3<f64>,
        bars: &Bars,
    ) -> Result<ArcTest, Failure> {
        let cells = Cells::new(self.dims, &self.rows)?;
        let found = plies(&cells, CELL_MM, &self.origin, strips)?;
        let all = f64::INFINITY;
        let high = self.specimen.solid().bounds().map_or(0.0, |[_, high]| high.z);
        let [left, right] = self.feet(&cells);
        let half = PRESSED_MM / 2.0;
        let crown = self.region([-half, -all, high - CELL_MM], [half, all, all]);
        let supports = [Support::fixed(left), Support { region: right, displacement_mm: [None, Some(0.0), Some(0.0)] }];
        let loads = [Load::Force { region: crown, newtons: [0.0, 0.0, -FORCE_N] }];
        let part = ElasticPart { cells: &cells, cell_mm: CELL_MM, material, supports: &supports, loads: &loads };
        let progress = |p: curvlay_layers::Progress| bars.show(p.stage, p.done, p.total);
        let elastic = solve_composite(&part, tape, &found.list, &ElasticOptions::default(), &progress)?;
        let sunk = elastic.mean_displacement(self.dims, CELL_MM, &crown).map_or(f64::NAN, |u| -u[2]);
        let bonds = self.bonds(&cells, &elastic, &found.list, normal);
        Ok(ArcTest {
            stiffness_n_mm: FORCE_N / sunk,
            apart_n_mpa: FORCE_N * load_factor(&bonds, APART),
            tape_mm3: found.tape_mm3,
        })
    }

    /// How far bonds are loaded, for one of 1 MPa, and their area: between layers, and along tapes.
    fn bonds(
        &self,
        cells: &Cells,
        elastic: &Elastic,
        plies: &[Ply],
        normal: &dyn Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Vec<(f64, f64)> {
        let bond = Bond { peel_mpa: 1.0, shear_mpa: 1.0 };
        let foot = self.specimen.solid().bounds().map_or(0.0, |[low, _]| low.z);
        let judged = elastic.cells.iter().zip(&elastic.stresses_mpa).filter_map(|(&cell, stress)| {
            let at = self.centre(cells.position(cell));
            if at.x.abs() < FREE_MM || at.z < foot + FREE_MM {
                return None;
            }
            let ply = plies.binary_search_by_key(&cell, |ply| ply.cell).ok().map(|k| plies[k].normal);
            Some((bond.index(stress, &ply.unwrap_or_else(|| normal(&at))), CELL_MM * CELL_MM))
        });
        judged.collect()
    }
}

/// A tape as the solver takes it.
pub fn strip(tape: &Tape) -> Strip<'_> {
    Strip { points: &tape.points, normals: &tape.normals, width_mm: tape.width, thickness_mm: tape.thickness }
}

/// What bonds between layers bear in MPa, so that planar layers come apart where those of the dissertation did.
pub fn bond_mpa(specimen: &Specimen, force_n: f64, bars: &Bars) -> Result<f64, Failure> {
    let cells = ArcCells::new(specimen).ok_or_else(|| Failure::new("this specimen is no arc"))?;
    let material = Material::default();
    let none = (&Orthotropic::isotropic(&material), &[][..]);
    Ok(force_n / cells.test(material, none, &|_| Vector3::z(), bars)?.apart_n_mpa)
}

/// Runs the test on all four arcs.
///
/// # Arguments
/// * `matrix_gpa`: modulus of the thermoplastic; `tape`: what tapes are.
pub fn run(arc: &Planned, planar: &Planar, matrix_gpa: f64, tape: &Orthotropic, bars: &Bars) -> Result<Arcs, Failure> {
    let Some(cells) = ArcCells::new(&arc.specimen) else {
        return Err(Failure::new("this specimen is no arc"));
    };
    let material = Material { young_mpa: 1e3 * matrix_gpa, ..Material::default() };
    // The planar layers stand on the ends of the arc.
    let (radius, half) = arc.specimen.arc().unwrap_or((0.0, 0.0));
    let inner = radius - arc.specimen.section_mm()[1] / 2.0;
    let up = Vector3::z() * (CROWN_MM - inner + inner * half.cos());
    let lifted = |tape: &Tape| Tape { points: tape.points.iter().map(|point| point + up).collect(), ..tape.clone() };
    let flat: Vec<Tape> = planar.tapes.iter().map(lifted).collect();
    let curved: Vec<Strip> = arc.tapes.iter().flat_map(|list| &list.tapes).map(strip).collect();
    let flat: Vec<Strip> = flat.iter().map(strip).collect();
    let (along, level) = (|at: &Point3<f64>| cells.up(at), |_: &Point3<f64>| Vector3::z());
    Ok(Arcs {
        planar: cells.test(material, (tape, &[]), &level, bars)?,
        planar_taped: cells.test(material, (tape, &flat), &level, bars)?,
        curved: cells.test(material, (tape, &[]), &along, bars)?,
        curved_taped: cells.test(material, (tape, &curved), &along, bars)?,
    })
}
