//! The inverse of an arm as built: Newton's method from each branch of the nearest closed form.
//!
//! A calibrated arm has no closed form, but one near by. Each of its branches is a first guess, off by about the deviation
//! of the axes, and damped least squares ([`follow`](super::follow)) take it to the pose in three or four steps; where the
//! arm is regular that is Newton's method, and converges as fast.
//!
//! Beside a singularity and at the ends of reach the guess may be far off, or there is none: two branches of the arm as
//! built may meet the pose where the nominal one has none, and the other way round. So where a branch is lost, or moves
//! far, the closed forms of poses around this one are guesses as well: shifted and turned by twice what the deviation
//! amounts to, both ways along each axis. At a singularity two branches come together along the joints' direction that moves the
//! flange least: from a solution near one the other is looked for along it, both ways.
//!
//! Solutions are on the branch that their joints say. Where the singular postures of both arms differ, two solutions may
//! have the same signs: the second is then given in a free slot.

use super::branches::Solutions;
use super::deviation::Deviation;
use super::follow::{FAR, NO_STOPS};
use super::jacobian::jacobian_of;
use super::numbers::{HELD, meets};
use super::planar::Free;
use super::solver::Arm;
use crate::angle::nearest_image;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Joints that move more than this from the guess, in radians, are beside a singularity: there the deviation of an arm, some
/// hundredths of a radian, counts a multiple. A smaller number looks around more poses, a larger one loses branches.
const MOVED: f64 = 0.2;

/// The least singular value of the Jacobian, in longest links, below which a solution is near a singularity: its twin is then about as
/// far away in radians, or a few times that; around a singular wrist it may be half a turn.
const NEAR_SINGULAR: f64 = 0.15;

/// How far twins are looked for, in radians: each finds those up to about twice as far.
const TWINS: [f64; 7] = [0.01, 0.04, 0.12, 0.4, 1.0, 2.0, 3.0];

/// Guesses come from poses that are this many times the deviation away: once is on the edge of what the arm as built reaches.
const AROUND: [f64; 2] = [0.5, 2.0];

impl Arm {
    /// Solutions in the geometry's joints, which meet the pose.
    pub(super) fn branches_near(
        &self,
        r: &Matrix3<f64>,
        p: &Vector3<f64>,
        free: &Free,
        deviation: &Deviation,
    ) -> Solutions {
        let mut found = Solutions::EMPTY;
        let mut is_regular = true;
        for (branch, guess) in self.nearest_closed_form(r, p, free).iter() {
            let solution = self.newton(r, p, guess);
            let stays = |q: &[f64; 6]| (0..6).all(|k| (q[k] - guess[k]).abs() <= MOVED);
            is_regular &= solution.as_ref().is_some_and(stays);
            if let Some(q) = solution {
                is_regular &= self.slot_of(&q) == branch.slot();
                self.add(&mut found, q, branch.slot(), r, p);
            }
        }
        if is_regular && found.len() == 8 {
            return found;
        }
        for (r_near, p_near) in self.poses_around(r, p, deviation) {
            for (branch, guess) in self.nearest_closed_form(&r_near, &p_near, free).iter() {
                if is_regular && found.get(branch).is_some() {
                    continue;
                }
                if let Some(q) = self.newton(r, p, guess) {
                    self.add(&mut found, q, branch.slot(), r, p);
                }
            }
        }
        if !is_regular {
            self.add_twins(&mut found, r, p);
        }
        found
    }

    /// Adds the solutions that come together with those that are known, at a singularity near by.
    fn add_twins(&self, found: &mut Solutions, r: &Matrix3<f64>, p: &Vector3<f64>) {
        let mut asked = 0u8;
        // Those that are found on the way are asked as well.
        while let Some(slot) = (0..8).find(|slot| asked >> slot & 1 == 0 && found.at(*slot).is_some()) {
            asked |= 1 << slot;
            let Some(&q) = found.at(slot) else { continue };
            let mut slopes = jacobian_of(&self.inner_axes(&q), &self.flange(&q).1);
            slopes.fixed_rows_mut::<3>(0).scale_mut(1.0 / self.longest_link());
            let svd = slopes.svd(false, true);
            let least = svd.singular_values.imin();
            let Some(v_t) = svd.v_t.filter(|_| svd.singular_values[least] < NEAR_SINGULAR) else { continue };
            for far in TWINS.into_iter().flat_map(|far| [far, -far]) {
                let guess = std::array::from_fn(|k| q[k] + far * v_t[(least, k)]);
                if let Some(twin) = self.newton(r, p, &guess) {
                    self.add(found, twin, self.slot_of(&twin), r, p);
                }
            }
        }
    }

    /// From a guess to joints that meet the pose, angles in one turn.
    fn newton(&self, r: &Matrix3<f64>, p: &Vector3<f64>, guess: &[f64; 6]) -> Option<[f64; 6]> {
        let q = self.follow(r, p, guess, &NO_STOPS, FAR)?;
        meets(&self.flange(&q), r, p, HELD).then_some(q)
    }

    fn slot_of(&self, q: &[f64; 6]) -> usize {
        self.nearest_branch(q).slot()
    }

    /// Puts a solution into the slot of its signs; if that is taken, into that of its guess, or the first free one. One that equals
    /// another for this pose is left out.
    fn add(&self, found: &mut Solutions, q: [f64; 6], guessed: usize, r: &Matrix3<f64>, p: &Vector3<f64>) {
        let is_known = found.iter().any(|(_, other)| {
            let image: [f64; 6] = std::array::from_fn(|k| nearest_image(q[k], other[k]));
            let near = (0..6).all(|k| (image[k] - other[k]).abs() <= MOVED);
            let between: [f64; 6] = std::array::from_fn(|k| 0.5 * (image[k] + other[k]));
            near && meets(&self.flange(&between), r, p, 1.0)
        });
        if is_known {
            return;
        }
        let slot = [self.slot_of(&q), guessed].into_iter().chain(0..8).find(|&slot| found.at(slot).is_none());
        if let Some(slot) = slot {
            found.put(slot, q);
        }
    }

    /// The pose shifted and turned, both ways along each axis.
    fn poses_around(
        &self,
        r: &Matrix3<f64>,
        p: &Vector3<f64>,
        deviation: &Deviation,
    ) -> impl Iterator<Item = (Matrix3<f64>, Vector3<f64>)> {
        let size = deviation.turn + deviation.shift_mm / self.longest_link();
        let (r, p, link) = (*r, *p, self.longest_link());
        let sides = (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 }));
        let steps = AROUND
            .into_iter()
            .flat_map(move |share| sides.clone().map(move |along: Vector3<f64>| along * (share * size)));
        steps.flat_map(move |step| {
            let turned = r * Rotation3::from_scaled_axis(step).matrix();
            [(r, p + step * link), (turned, p)]
        })
    }
}
