//! Parts with tapes of fibre in them: stiffness, and where they come apart.
//!
//! Each cell that a tape passes through is a laminate of the tape and the thermoplastic, with the direction of the tape in this cell
//! ([`laminate`](super::laminate)); so curved tapes and planar ones differ. Tapes are spread over the cells around them by shares that keep their volume and
//! its centre, as particles are in a grid (R. W. Hockney, J. W. Eastwood, *Computer Simulation Using Particles*, 1988, section 5-2-3).
//!
//! Stresses across a layer pass from one material into the other unchanged. So the stress of a cell says what the bond between tape and thermoplastic, or
//! between two layers, has to bear: peel and shear, judged by a quadratic criterion (J. C. Brewer, P. A. Lagace, "Quadratic stress criterion for
//! initiation of delamination", J. Compos. Mater. 22(12), 1988): it comes apart where `(peel / Z)^2 + (shear / S)^2` reaches 1, `peel` being tension alone.
//! Bonds are perfect up to there.

use super::material::stress_matrix;
use super::orthotropic::{Orthotropic, axes, laminate, rotated};
use super::{Elastic, ElasticError, ElasticOptions, ElasticPart, Laws, solve};
use crate::ProgressFn;
use crate::cells::Cells;
use nalgebra::{Matrix6, Point3, UnitVector3, Vector3};
use std::collections::BTreeMap;

/// Samples of a strip to the edge of a cell: tapes are wide beside cells, or long.
const SAMPLES_A_CELL: f64 = 4.0;

/// A tape as a strip in space.
#[derive(Clone, Copy, Debug)]
pub struct Strip<'a> {
    /// Its centre line, two points at least, in millimetres.
    pub points: &'a [Point3<f64>],
    /// The normal of its plane at each point.
    pub normals: &'a [UnitVector3<f64>],
    /// Width in millimetres.
    pub width_mm: f64,
    /// Thickness in millimetres.
    pub thickness_mm: f64,
}

/// The part of a tape in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ply {
    /// The cell.
    pub cell: u32,
    /// Along the fibres; its length says nothing.
    pub direction: Vector3<f64>,
    /// The normal of the tape's plane; its length says nothing.
    pub normal: Vector3<f64>,
    /// Share of the cell that is tape, above 0 and up to 1.
    pub share: f64,
}

/// Tapes in cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plies {
    /// One for each cell that has any, by rising number.
    pub list: Vec<Ply>,
    /// Volume of all strips in cubic millimetres.
    pub tape_mm3: f64,
    /// What of it lies in no cell of the part, or does not fit into its cell beside others.
    pub lost_mm3: f64,
}

/// Spreads tapes over the cells around them: volume and its centre stay, but where there are no cells on one side.
///
/// # Arguments
/// * `origin`: low corner of the grid in the frame of the strips, in millimetres.
///
/// # Errors
/// [`ElasticError::Strip`] and [`ElasticError::FineStrip`] name the strip.
///
/// # Cost
/// `O(n)` for `n` samples, 16 a square of tape as large as a cell's face.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::elastic::{Strip, plies};
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// // A tape whose middle lies on the face between two layers of cells: half of it in each.
/// let rows = [0b1111; 8];
/// let cells = Cells::new([4, 4, 2], &rows)?;
/// let points = [Point3::new(0.5, 2.0, 0.95), Point3::new(3.5, 2.0, 0.95)];
/// let strip = Strip { points: &points, normals: &[Vector3::z_axis(); 2], width_mm: 2.0, thickness_mm: 0.1 };
/// let plies = plies(&cells, 1.0, &Point3::origin(), &[strip])?;
/// let volume = |upper: bool| plies.list.iter().filter(|ply| (ply.cell >= 16) == upper).map(|ply| ply.share).sum::<f64>();
/// assert!((volume(true) - 0.3).abs() < 1e-12 && (volume(false) - 0.3).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plies(cells: &Cells, cell_mm: f64, origin: &Point3<f64>, strips: &[Strip]) -> Result<Plies, ElasticError> {
    if !(cell_mm > 0.0 && cell_mm.is_finite()) {
        return Err(ElasticError::Cell { cell_mm });
    }
    let mut spread = Spread { cells, cell_mm, volumes: BTreeMap::new(), lost_mm3: 0.0 };
    let mut tape_mm3 = 0.0;
    for (number, strip) in strips.iter().enumerate() {
        let is_size = |mm: f64| mm > 0.0 && mm.is_finite();
        let is_whole = strip.points.len() >= 2 && strip.points.len() == strip.normals.len();
        let is_finite = strip.points.iter().all(|point| point.iter().all(|x| x.is_finite()));
        if !(is_whole && is_finite && is_size(strip.width_mm) && is_size(strip.thickness_mm)) {
            return Err(ElasticError::Strip { strip: number });
        }
        if spread.samples(strip) > MAX_SAMPLES {
            return Err(ElasticError::FineStrip { strip: number });
        }
        tape_mm3 += spread.strip(strip, origin);
    }
    let cell_mm3 = cell_mm.powi(3);
    let mut lost_mm3 = spread.lost_mm3;
    let ply = |(cell, (volume, direction, normal)): (u32, (f64, Vector3<f64>, Vector3<f64>))| {
        lost_mm3 += (volume - cell_mm3).max(0.0);
        Ply { cell, direction, normal, share: (volume / cell_mm3).min(1.0) }
    };
    let list = spread.volumes.into_iter().map(ply).filter(|ply| axes(&ply.direction, &ply.normal).is_some());
    Ok(Plies { list: list.collect(), tape_mm3, lost_mm3 })
}

/// Most samples of a strip, 16 for each of ten million faces of cells: half a minute of them.
const MAX_SAMPLES: f64 = 1.6e8;

struct Spread<'a> {
    cells: &'a Cells<'a>,
    cell_mm: f64,
    /// By cell: volume, and directions and normals by volume.
    volumes: BTreeMap<u32, (f64, Vector3<f64>, Vector3<f64>)>,
    lost_mm3: f64,
}

impl Spread<'_> {
    /// Samples of a strip.
    fn samples(&self, strip: &Strip) -> f64 {
        let step = self.cell_mm / SAMPLES_A_CELL;
        let steps = strip.points.windows(2).map(|ends| ((ends[1] - ends[0]).norm() / step).ceil());
        steps.sum::<f64>() * (strip.width_mm / step).ceil().max(1.0)
    }

    /// Returns its volume.
    fn strip(&mut self, strip: &Strip, origin: &Point3<f64>) -> f64 {
        let Strip { points, normals, width_mm, thickness_mm } = *strip;
        let step = self.cell_mm / SAMPLES_A_CELL;
        let rows = (width_mm / step).ceil().max(1.0);
        let mut all = 0.0;
        for (ends, normals) in points.windows(2).zip(normals.windows(2)) {
            let way = ends[1] - ends[0];
            let length = way.norm();
            let steps = (length / step).ceil();
            let volume = length / steps * (width_mm / rows) * thickness_mm;
            for k in 0..steps as usize {
                let share = (k as f64 + 0.5) / steps;
                let normal = normals[0].into_inner() * (1.0 - share) + normals[1].into_inner() * share;
                let across = normal.cross(&way).try_normalize(1e-12).unwrap_or_else(Vector3::zeros);
                for row in 0..rows as usize {
                    let aside = width_mm * ((row as f64 + 0.5) / rows - 0.5);
                    let at = ends[0] + way * share + across * aside + normal * (0.5 * thickness_mm);
                    self.sample(&(at - origin), volume, &way, &normal);
                    all += volume;
                }
            }
        }
        all
    }

    /// Shares a sample among the eight cells whose centres are around it.
    fn sample(&mut self, at: &Vector3<f64>, volume: f64, direction: &Vector3<f64>, normal: &Vector3<f64>) {
        let place = at / self.cell_mm - Vector3::repeat(0.5);
        let low = place.map(f64::floor);
        let dims = self.cells.dims();
        let weight = |k: usize| {
            let along = |axis: usize| {
                let share = place[axis] - low[axis];
                if k >> axis & 1 == 1 { share } else { 1.0 - share }
            };
            let cell = [0, 1, 2].map(|axis| low[axis] + (k >> axis & 1) as f64);
            let is_in = (0..3).all(|axis| cell[axis] >= 0.0 && cell[axis] < f64::from(dims[axis]));
            let cell = cell.map(|c| c as u32);
            (is_in && self.cells.contains(cell)).then(|| (self.cells.id(cell), along(0) * along(1) * along(2)))
        };
        let found: Vec<(u32, f64)> = (0..8).filter_map(weight).filter(|(_, weight)| *weight > 0.0).collect();
        let sum: f64 = found.iter().map(|(_, weight)| weight).sum();
        if sum <= 0.0 {
            self.lost_mm3 += volume;
            return;
        }
        for (cell, weight) in found {
            let share = volume * weight / sum;
            let (all, along, up) = self.volumes.entry(cell).or_insert((0.0, Vector3::zeros(), Vector3::zeros()));
            // Fibres have no sense of direction.
            let sense = |sum: &Vector3<f64>, of: &Vector3<f64>| if sum.dot(of) < 0.0 { -1.0 } else { 1.0 };
            let direction = direction.normalize();
            *all += share;
            *along += direction * (share * sense(along, &direction));
            *up += normal * (share * sense(up, normal));
        }
    }
}

/// As [`solve_elastic`](super::solve_elastic) for a part with tapes: its material everywhere but in the cells of the plies, which are laminates of it and of `tape`.
///
/// # Errors
/// [`ElasticError`]; [`ElasticError::Ply`] for a ply without axes, of no cell, or with an invalid share, [`ElasticError::Orthotropic`].
///
/// # Cost
/// That of [`solve_elastic`](super::solve_elastic), and some 5 kilobytes for each cell with a direction of its own.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::elastic::*;
/// use curvlay_layers::nalgebra::Vector3;
/// // A bar of 2 x 2 x 10 cells with a tape along it in a tenth of each cell: the rule of mixtures.
/// let rows = [0b11; 20];
/// let cells = Cells::new([2, 2, 10], &rows)?;
/// let material = Material { young_mpa: 1000.0, poisson: 0.0 };
/// let part = ElasticPart {
///     cells: &cells,
///     cell_mm: 1.0,
///     material,
///     supports: &[Support::fixed(Region::plane(2, 0.0))],
///     loads: &[Load::Force { region: Region::plane(2, 10.0), newtons: [0.0, 0.0, 40.0] }],
/// };
/// let ply = |cell| Ply { cell, direction: Vector3::z(), normal: Vector3::x(), share: 0.1 };
/// let list: Vec<Ply> = cells.iter().map(ply).collect();
/// let tape = Orthotropic::tape(&material, 91_000.0, 0.1); // 10,000 MPa
/// let elastic = solve_composite(&part, &tape, &list, &ElasticOptions::default(), &|_| std::ops::ControlFlow::Continue(()))?;
/// let top = elastic.displacement(90 + 4).unwrap()[2];
/// assert!((top - 10.0 / (0.1 * 10_000.0 + 0.9 * 1000.0) * 10.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solve_composite(
    part: &ElasticPart,
    tape: &Orthotropic,
    plies: &[Ply],
    options: &ElasticOptions,
    progress: ProgressFn,
) -> Result<Elastic, ElasticError> {
    let tape = tape.law().ok_or(ElasticError::Orthotropic)?;
    let plain = part.material.law_of();
    let mut laws: BTreeMap<u32, Matrix6<f64>> = BTreeMap::new();
    for (ply, &Ply { cell, direction, normal, share }) in plies.iter().enumerate() {
        let is_there = cell < part.cells.dims().iter().product() && part.cells.contains(part.cells.position(cell));
        let axes = axes(&direction, &normal).filter(|_| is_there && share > 0.0 && share <= 1.0);
        let axes = axes.ok_or(ElasticError::Ply { ply })?;
        laws.insert(cell, rotated(&laminate(&tape, &plain, share), &axes));
    }
    solve(part, &Laws { plain, others: laws }, options, progress)
}

/// What a bond bears.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Bond {
    /// Tension across it in MPa.
    pub peel_mpa: f64,
    /// Shear along it in MPa.
    pub shear_mpa: f64,
}

impl Bond {
    /// How far a bond is loaded, 1 where it comes apart. It grows with the load: twice the load is twice the index.
    ///
    /// # Arguments
    /// * `stress_mpa`: xx, yy, zz, xy, yz, zx; `normal`: of the bond, of any length but none.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::elastic::Bond;
    /// use curvlay_layers::nalgebra::Vector3;
    /// let bond = Bond { peel_mpa: 10.0, shear_mpa: 5.0 };
    /// // Half of what it bears across, and none where it is pressed.
    /// assert_eq!(bond.index(&[0.0, 0.0, 5.0, 0.0, 0.0, 0.0], &Vector3::z()), 0.5);
    /// assert_eq!(bond.index(&[0.0, 0.0, -5.0, 0.0, 0.0, 0.0], &Vector3::z()), 0.0);
    /// assert!((bond.index(&[0.0, 0.0, 6.0, 0.0, 0.0, 4.0], &Vector3::z()) - 1.0).abs() < 1e-12);
    /// ```
    pub fn index(&self, stress_mpa: &[f64; 6], normal: &Vector3<f64>) -> f64 {
        let [peel, shear] = traction(stress_mpa, normal);
        (peel.max(0.0) / self.peel_mpa).hypot(shear / self.shear_mpa)
    }
}

/// Tension across a plane and shear along it in MPa, from a stress (xx, yy, zz, xy, yz, zx) and the plane's normal, of any length but none.
///
/// # Example
/// ```
/// use curvlay_layers::elastic::traction;
/// use curvlay_layers::nalgebra::Vector3;
/// // Pulled along x; the plane leans by 45 degrees.
/// let [peel, shear] = traction(&[8.0, 0.0, 0.0, 0.0, 0.0, 0.0], &Vector3::new(1.0, 0.0, 1.0));
/// assert!((peel - 4.0).abs() < 1e-12 && (shear - 4.0).abs() < 1e-12);
/// ```
pub fn traction(stress_mpa: &[f64; 6], normal: &Vector3<f64>) -> [f64; 2] {
    let normal = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::zeros);
    let force = stress_matrix(stress_mpa) * normal;
    let peel = force.dot(&normal);
    [peel, (force - normal * peel).norm()]
}

/// The factor of the load at which a share of bonds has come apart, from their indices and areas: infinite where none is loaded.
///
/// # Example
/// ```
/// use curvlay_layers::elastic::load_factor;
/// // A tenth of the area has index 0.5: it comes apart at twice the load.
/// assert_eq!(load_factor(&[(0.5, 1.0), (0.1, 9.0)], 0.1), 2.0);
/// assert_eq!(load_factor(&[(0.5, 1.0), (0.1, 9.0)], 0.2), 10.0);
/// ```
pub fn load_factor(bonds: &[(f64, f64)], share: f64) -> f64 {
    let mut bonds = bonds.to_vec();
    bonds.sort_by(|a, b| b.0.total_cmp(&a.0));
    let wanted = share * bonds.iter().map(|(_, area)| area).sum::<f64>();
    let mut apart = 0.0;
    let index = bonds.iter().find_map(|(index, area)| {
        apart += area;
        (apart >= wanted * (1.0 - 1e-12)).then_some(*index)
    });
    index.map_or(f64::INFINITY, |index| if index > 0.0 { 1.0 / index } else { f64::INFINITY })
}
