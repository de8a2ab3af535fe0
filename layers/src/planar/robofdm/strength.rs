//! Whether seams hold: the stress in the seam below a part, from the weight of what it carries and the force of the nozzle on it.
//!
//! Section 2.5 of the dissertation calls seams the weak places of a print; it sets no least size. Here the seam of a part is a section under a
//! force and a bending moment (beam theory): `stress = force / A + moment / Z`. The moment is the worst of all directions, since the robot may
//! hold the part any way up and the nozzle may push from any side: `Z` is the least section modulus over all directions of the moment, with the
//! products of inertia of sections that are not symmetric.
//!
//! What a seam carries is what would come off if it gave way, at the worst time of the print: later parts that also rest on others carry with it
//! once they are printed.

use crate::union_find::UnionFind;
use nalgebra::{Matrix2, Point3, Vector2, Vector3};

/// Gravity, in m/s2.
const GRAVITY: f64 = 9.806_65;

/// What a seam must hold, and how strong the bond is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamStrength {
    /// Density of the material, in g/cm3. Default 1.24, that of PLA.
    pub density_g_cm3: f64,
    /// Force of the nozzle on the part, in N: from any side, at the farthest place of what is carried. Default 1; assumed.
    pub print_force_n: f64,
    /// Tensile strength of the bond between a part and those it is printed on, in MPa. Default 20; assumed: PLA across its layers.
    pub bond_mpa: f64,
    /// The same of the bond to the platform. Default 5; assumed: it depends on the plate more than on the material.
    pub platform_bond_mpa: f64,
    /// By which factor the stress must stay below the strength, at least 1. Default 2.
    pub safety: f64,
}

impl Default for SeamStrength {
    fn default() -> Self {
        SeamStrength { density_g_cm3: 1.24, print_force_n: 1.0, bond_mpa: 20.0, platform_bond_mpa: 5.0, safety: 2.0 }
    }
}

impl SeamStrength {
    /// The fields with their bounds, for the check of options.
    pub(super) fn ranges(&self) -> [(&'static str, f64, f64, f64); 5] {
        [
            ("strength.density_g_cm3", self.density_g_cm3, 0.0, 1e3),
            ("strength.print_force_n", self.print_force_n, 0.0, 1e6),
            ("strength.bond_mpa", self.bond_mpa, 1e-9, 1e6),
            ("strength.platform_bond_mpa", self.platform_bond_mpa, 1e-9, 1e6),
            ("strength.safety", self.safety, 1.0, 1e6),
        ]
    }

    /// Weight of a volume, in N.
    fn weight_n(&self, mm3: f64) -> f64 {
        1e-6 * self.density_g_cm3 * mm3 * GRAVITY
    }
}

/// A seam as a section under load: its area, its middle, and its least section modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamSection {
    /// Area, in mm2.
    pub area_mm2: f64,
    /// Centroid, in mm.
    pub centre: Point3<f64>,
    /// Least section modulus over all directions of the moment, in mm3: a moment in N mm over it is the greatest stress in MPa.
    pub modulus_mm3: f64,
}

impl SeamSection {
    /// The section that triangles make, seen along the sum of their normals; `None` if they have no area, or their normals cancel.
    ///
    /// # Cost
    /// Some operations for each triangle.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Point3;
    /// use curvlay_layers::planar::robofdm::SeamSection;
    /// // A square of 6 mm: the worst moment turns about a diagonal.
    /// let [a, b, c, d] = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]].map(|[x, y]| Point3::new(x, y, 2.0));
    /// let seam = SeamSection::of(&[[a, b, c], [a, c, d]]).unwrap();
    /// assert!((seam.modulus_mm3 - 6f64.powi(3) / (6.0 * 2f64.sqrt())).abs() < 1e-9);
    /// ```
    pub fn of(triangles: &[[Point3<f64>; 3]]) -> Option<Self> {
        let vector = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)) / 2.0;
        let area_mm2: f64 = triangles.iter().map(|corners| vector(corners).norm()).sum();
        let sum: Vector3<f64> = triangles.iter().map(vector).sum();
        let normal = sum.try_normalize(1e-9 * area_mm2).filter(|_| area_mm2 > 0.0)?;
        let third = |[a, b, c]: &[Point3<f64>; 3]| (a.coords + b.coords + c.coords) / 3.0;
        let moment: Vector3<f64> = triangles.iter().map(|corners| third(corners) * vector(corners).norm()).sum();
        let centre = Point3::from(moment / area_mm2);
        let u = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        let v = normal.cross(&u);
        let flat = |p: &Point3<f64>| Vector2::new((p - centre).dot(&u), (p - centre).dot(&v));
        // The integral of p p^T over a triangle.
        let second = |corners: &[Point3<f64>; 3]| {
            let flat = corners.each_ref().map(flat);
            let all = flat[0] + flat[1] + flat[2];
            let squares: Matrix2<f64> = flat.iter().map(|p| p * p.transpose()).sum();
            (squares + all * all.transpose()) * (vector(corners).norm() / 12.0)
        };
        let inertia: Matrix2<f64> = triangles.iter().map(second).sum();
        let inverse = inertia.try_inverse()?;
        // Stress at p under a moment m is (m turned by a right angle) . inverse p.
        let worst = triangles.iter().flatten().map(|p| (inverse * flat(p)).norm()).fold(0.0, f64::max);
        let modulus_mm3 = 1.0 / worst;
        (modulus_mm3 > 0.0 && modulus_mm3.is_finite()).then_some(SeamSection { area_mm2, centre, modulus_mm3 })
    }

    /// The greatest tensile stress under a force in N and a moment in N mm of the worst directions, in MPa.
    pub fn stress_mpa(&self, force_n: f64, moment_nmm: f64) -> f64 {
        force_n / self.area_mm2 + moment_nmm / self.modulus_mm3
    }
}

/// How a part is held by the seam below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The part, from 0.
    pub part: usize,
    /// Whether its seam is that with the platform.
    pub on_platform: bool,
    /// The seam; `None` for one without area.
    pub section: Option<SeamSection>,
    /// Volume that it carries at the worst time, in mm3.
    pub carried_mm3: f64,
    /// Moment on it then, in N mm.
    pub moment_nmm: f64,
    /// The greatest stress in it then, in MPa; infinite for one without area.
    pub stress_mpa: f64,
    /// What it may be: the strength of the bond over the factor of safety, in MPa.
    pub allowed_mpa: f64,
}

impl Hold {
    /// The stress as a share of what it may be; above 1 the seam is too weak.
    pub fn share(&self) -> f64 {
        self.stress_mpa / self.allowed_mpa
    }
}

/// What is known of a part's mass and place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Volume, and its first moment.
    volume: f64,
    moment: Vector3<f64>,
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Body {
    pub(super) fn of<'a>(triangles: impl Iterator<Item = &'a [Point3<f64>; 3]>) -> Self {
        let mut body = Body {
            volume: 0.0,
            moment: Vector3::zeros(),
            low: Point3::from([f64::INFINITY; 3]),
            high: Point3::from([f64::NEG_INFINITY; 3]),
        };
        for [a, b, c] in triangles {
            let six = a.coords.dot(&b.coords.cross(&c.coords));
            body.volume += six / 6.0;
            body.moment += (a.coords + b.coords + c.coords) * (six / 24.0);
            body.low = body.low.inf(a).inf(b).inf(c);
            body.high = body.high.sup(a).sup(b).sup(c);
        }
        body
    }

    /// Distance of the farthest corner of its box: never too small.
    fn farthest(&self, from: &Point3<f64>) -> f64 {
        let along = |axis: usize| (from[axis] - self.low[axis]).abs().max((self.high[axis] - from[axis]).abs());
        Vector3::new(along(0), along(1), along(2)).norm()
    }
}

/// A part with its seam.
pub(super) struct Joined {
    pub(super) body: Body,
    /// The earlier parts that it touches.
    pub(super) on: Vec<usize>,
    /// Its seam with them, or with the platform.
    pub(super) section: Option<SeamSection>,
    pub(super) on_platform: bool,
}

/// Parts that hang together, and what they come to.
struct Groups {
    sets: UnionFind,
    volume: Vec<f64>,
    moment: Vec<Vector3<f64>>,
    farthest: Vec<f64>,
    stands: Vec<bool>,
}

impl Groups {
    fn join(&mut self, a: usize, b: usize) {
        if let Some([a, b]) = self.sets.join_to(a as u32, b as u32).map(|roots| roots.map(|root| root as usize)) {
            self.volume[a] += self.volume[b];
            let moment = self.moment[b];
            self.moment[a] += moment;
            self.farthest[a] = self.farthest[a].max(self.farthest[b]);
            self.stands[a] |= self.stands[b];
        }
    }
}

/// How each part is held.
///
/// # Arguments
/// * `lowered`: by how much the seam with the platform lies below the first part: the pedestal, along the first direction.
pub(super) fn holds(parts: &[Joined], strength: &SeamStrength, lowered: &Vector3<f64>) -> Vec<Hold> {
    (0..parts.len()).map(|part| hold(parts, part, strength, lowered)).collect()
}

fn hold(parts: &[Joined], part: usize, strength: &SeamStrength, lowered: &Vector3<f64>) -> Hold {
    let Joined { section, on_platform, .. } = parts[part];
    let bond = if on_platform { strength.platform_bond_mpa } else { strength.bond_mpa };
    let allowed_mpa = bond / strength.safety;
    let mut hold = Hold {
        part,
        on_platform,
        section,
        carried_mm3: parts[part].body.volume,
        moment_nmm: f64::INFINITY,
        stress_mpa: f64::INFINITY,
        allowed_mpa,
    };
    let Some(seam) = section else { return hold };
    (hold.moment_nmm, hold.stress_mpa) = (0.0, 0.0);
    let centre = if on_platform { seam.centre - lowered } else { seam.centre };
    let mut groups = Groups {
        sets: UnionFind::new(parts.len()),
        volume: parts.iter().map(|part| part.body.volume).collect(),
        moment: parts.iter().map(|part| part.body.moment).collect(),
        farthest: parts.iter().map(|part| part.body.farthest(&centre)).collect(),
        stands: parts.iter().enumerate().map(|(at, other)| other.on_platform && at != part).collect(),
    };
    for (at, other) in parts.iter().enumerate() {
        if at != part {
            other.on.iter().for_each(|&on| groups.join(on, at));
        }
        let group = groups.sets.root(part as u32) as usize;
        if at < part || groups.stands[group] {
            continue;
        }
        let volume = groups.volume[group];
        let weight_n = strength.weight_n(volume);
        let middle = Point3::from(groups.moment[group] / volume.max(f64::MIN_POSITIVE));
        let moment_nmm = weight_n * (middle - centre).norm() + strength.print_force_n * groups.farthest[group];
        let stress_mpa = seam.stress_mpa(weight_n + strength.print_force_n, moment_nmm);
        if stress_mpa > hold.stress_mpa {
            hold = Hold { carried_mm3: volume, moment_nmm, stress_mpa, ..hold };
        }
    }
    hold
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::solid::BOX;

    /// A box as triangles, counter-clockwise from outside.
    fn block(low: [f64; 3], high: [f64; 3]) -> Vec<[Point3<f64>; 3]> {
        let corner =
            |i: u32| Point3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }));
        BOX.map(|face| face.map(corner)).to_vec()
    }

    fn rectangle(low: [f64; 2], high: [f64; 2], z: f64) -> Option<SeamSection> {
        let [a, b, c, d] = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
            .map(|[x, y]| Point3::new(x, y, z));
        SeamSection::of(&[[a, b, c], [a, c, d]])
    }

    #[test]
    fn sections_have_their_closed_forms() {
        let seam = rectangle([1.0, 2.0], [5.0, 10.0], 3.0).unwrap();
        assert!((seam.area_mm2 - 32.0).abs() < 1e-12 && (seam.centre - Point3::new(3.0, 6.0, 3.0)).norm() < 1e-12);
        // 6 / (b h) sqrt(1/b2 + 1/h2) is the greatest stress at a corner under a moment of 1.
        let worst = 6.0 / 32.0 * (1.0f64 / 16.0 + 1.0 / 64.0).sqrt();
        assert!((seam.modulus_mm3 * worst - 1.0).abs() < 1e-12);
        // A disc: pi r3 / 4.
        let rim = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / 2000.0).sin_cos();
            Point3::new(1.0, 3.0 * cos, 3.0 * sin)
        };
        let disc: Vec<_> = (0..2000).map(|k| [Point3::new(1.0, 0.0, 0.0), rim(k), rim(k + 1)]).collect();
        let seam = SeamSection::of(&disc).unwrap();
        assert!((seam.modulus_mm3 / (std::f64::consts::PI * 27.0 / 4.0) - 1.0).abs() < 1e-5, "{}", seam.modulus_mm3);
        assert_eq!(SeamSection::of(&[]), None);
        assert_eq!(SeamSection::of(&[[Point3::origin(); 3]]), None);
    }

    #[test]
    fn the_modulus_of_an_ell_is_the_least_of_all_directions() {
        // Two rectangles: no axis of symmetry along x or y. Moments of all directions, corner by corner, by the theory of skew bending
        // in principal axes: another way than the matrix.
        let pieces = [([0.0, 0.0], [2.0, 9.0]), ([2.0, 0.0], [7.0, 1.0])];
        let triangles: Vec<_> = pieces
            .iter()
            .flat_map(|(low, high)| {
                let [a, b, c, d] = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
                    .map(|[x, y]: [f64; 2]| Point3::new(x, y, 0.0));
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let seam = SeamSection::of(&triangles).unwrap();
        let (mut ixx, mut iyy, mut ixy) = (0.0, 0.0, 0.0);
        let (cx, cy) = (seam.centre.x, seam.centre.y);
        for (low, high) in pieces {
            let (w, h) = (high[0] - low[0], high[1] - low[1]);
            let (dx, dy) = (low[0] + w / 2.0 - cx, low[1] + h / 2.0 - cy);
            ixx += w * h * (w * w / 12.0 + dx * dx);
            iyy += w * h * (h * h / 12.0 + dy * dy);
            ixy += w * h * dx * dy;
        }
        let turn: f64 = 0.5 * (2.0 * ixy).atan2(ixx - iyy);
        let (s, c) = turn.sin_cos();
        let (i1, i2) = (ixx * c * c + 2.0 * ixy * s * c + iyy * s * s, ixx * s * s - 2.0 * ixy * s * c + iyy * c * c);
        let mut worst: f64 = 0.0;
        for step in 0..3600 {
            let (m2, m1) = (std::f64::consts::TAU * f64::from(step) / 3600.0).sin_cos();
            for p in triangles.iter().flatten() {
                let (x, y) = (p.x - cx, p.y - cy);
                let (a, b) = (x * c + y * s, y * c - x * s);
                worst = worst.max(m1 * a / i1 + m2 * b / i2);
            }
        }
        assert!((seam.modulus_mm3 * worst - 1.0).abs() < 1e-5, "{} {worst}", seam.modulus_mm3);
    }

    #[test]
    fn a_block_on_a_neck_bends_it_by_its_weight_and_the_force() {
        // A foot, a neck of 2 by 2, and a block of 10 x 10 x 20 whose middle is 10 above the neck and 4 beside it.
        let foot = Body::of(block([-10.0, -10.0, 0.0], [10.0, 10.0, 2.0]).iter());
        let block = Body::of(block([-1.0, -5.0, 4.0], [9.0, 5.0, 24.0]).iter());
        let neck = rectangle([-1.0, -1.0], [1.0, 1.0], 4.0);
        let parts = [
            Joined { body: foot, on: vec![], section: rectangle([-10.0, -10.0], [10.0, 10.0], 0.0), on_platform: true },
            Joined { body: block, on: vec![0], section: neck, on_platform: false },
        ];
        let strength = SeamStrength { print_force_n: 3.0, density_g_cm3: 2.0, ..SeamStrength::default() };
        let holds = holds(&parts, &strength, &Vector3::zeros());
        let weight = 2000.0 * 2e-6 * GRAVITY;
        let arm = (16.0f64 + 100.0).sqrt();
        let farthest = (81.0f64 + 25.0 + 400.0).sqrt();
        let moment = weight * arm + 3.0 * farthest;
        let stress = (weight + 3.0) / 4.0 + moment / (8.0 / (6.0 * 2f64.sqrt()));
        assert!((holds[1].moment_nmm - moment).abs() < 1e-9 && (holds[1].stress_mpa - stress).abs() < 1e-9);
        assert!((holds[1].carried_mm3 - 2000.0).abs() < 1e-9 && !holds[1].on_platform);
        assert!(holds[1].share() > 1.0 && (holds[1].allowed_mpa - 10.0).abs() < 1e-12);
        // The foot carries both; a pedestal makes its lever longer.
        assert!((holds[0].carried_mm3 - 2800.0).abs() < 1e-9 && holds[0].on_platform);
        let raised = super::holds(&parts, &strength, &(Vector3::z() * 5.0));
        assert!(raised[0].moment_nmm > holds[0].moment_nmm && (raised[1].stress_mpa - stress).abs() < 1e-9);
    }

    #[test]
    fn a_later_part_that_rests_on_two_carries_with_them() {
        // Two posts on a foot, then a beam on both: without one post's seam the beam holds the post.
        let bodies = [
            block([0.0, 0.0, 0.0], [30.0, 4.0, 2.0]),
            block([0.0, 0.0, 2.0], [4.0, 4.0, 12.0]),
            block([26.0, 0.0, 2.0], [30.0, 4.0, 12.0]),
            block([0.0, 0.0, 12.0], [30.0, 4.0, 14.0]),
        ]
        .map(|triangles| Body::of(triangles.iter()));
        let on = [vec![], vec![0], vec![0], vec![1, 2]];
        let joined = |on: &[Vec<usize>]| -> Vec<Joined> {
            let part = |k: usize| Joined {
                body: bodies[k],
                on: on[k].clone(),
                section: rectangle([0.0, 0.0], [4.0, 4.0], 2.0),
                on_platform: k == 0,
            };
            (0..4).map(part).collect()
        };
        let strength = SeamStrength::default();
        let both = holds(&joined(&on), &strength, &Vector3::zeros());
        assert!((both[1].carried_mm3 - 160.0).abs() < 1e-9, "{:?}", both[1]);
        // On the second post alone it hangs on that.
        let alone = holds(&joined(&[vec![], vec![0], vec![0], vec![2]]), &strength, &Vector3::zeros());
        assert!((alone[1].carried_mm3 - 160.0).abs() < 1e-9 && (alone[2].carried_mm3 - 400.0).abs() < 1e-9);
        // A seam without area holds nothing.
        let mut none = joined(&on);
        none[1].section = None;
        assert!(holds(&none, &strength, &Vector3::zeros())[1].share().is_infinite());
    }
}
