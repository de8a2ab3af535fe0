//! Boolean check and distance at one posture.

use super::Scene;
use super::body::Mount;
use super::chain::Line;
use super::piece::Piece;
use super::rounding;
use super::search::{Found, Meeting};
use nalgebra::{Isometry3, Point3, Translation3};

/// Joints of the arm, and of the positioner or the track where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// The arm's joints.
    pub joints: [f64; 6],
    /// Tilt and turn of a positioner, or the joint of a [`Track`](crate::Track) and 0; ignored without either.
    pub table: [f64; 2],
}

impl From<[f64; 6]> for Posture {
    fn from(joints: [f64; 6]) -> Self {
        Posture { joints, table: [0.0; 2] }
    }
}

/// An invalid posture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PostureError {
    /// A joint is infinite, not a number, or so many turns away that its angle has no digits left.
    #[error("{} {} is {value}: it must be an angle of less than 1e6 rad", if *table { "axis of the table" } else { "joint" }, joint + 1)]
    Joint {
        /// Whether it is one of the table.
        table: bool,
        /// Which one, counted from 0.
        joint: usize,
        /// Its value.
        value: f64,
    },
    /// The distance within which the nearest bodies are looked for is not a number.
    #[error("`within` is not a number")]
    Within,
}

/// Two bodies and the points at which they are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest<'a> {
    /// Their names.
    pub bodies: [&'a str; 2],
    /// Their distance in millimetres; 0 when they touch or overlap. The margin is not subtracted.
    pub distance: f64,
    /// The points on their surfaces, in the base; none when they touch or overlap.
    pub points: Option<[Point3<f64>; 2]>,
}

/// The nearest two bodies, and how their distance changes with the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance<'a> {
    /// The two bodies.
    pub nearest: Nearest<'a>,
    /// Derivative of the distance by the arm's joints, in millimetres a radian; zero where the bodies touch or overlap.
    pub joints: [f64; 6],
    /// The same by tilt and turn, or by the joint of a track.
    pub table: [f64; 2],
}

/// Joints beyond this are refused.
const MAX_JOINT: f64 = 1e6;

impl Posture {
    pub(super) fn check(&self, with_table: bool) -> Result<(), PostureError> {
        let wild = |angles: &[f64]| angles.iter().position(|angle| angle.is_nan() || angle.abs() >= MAX_JOINT);
        if let Some(joint) = wild(&self.joints) {
            return Err(PostureError::Joint { table: false, joint, value: self.joints[joint] });
        }
        match wild(&self.table) {
            Some(joint) if with_table => Err(PostureError::Joint { table: true, joint, value: self.table[joint] }),
            _ => Ok(()),
        }
    }
}

/// Where all pieces are at a posture, in the order of bodies and pieces.
pub(super) struct Poses {
    /// The first piece of each body.
    first: Vec<usize>,
    poses: Vec<Isometry3<f64>>,
    centers: Vec<Point3<f64>>,
    /// Frames of the arm, base to flange, and of the table: the base, tilted, turned; of a track the second is the ground.
    frames: ([Isometry3<f64>; 7], [Isometry3<f64>; 3]),
}

impl Scene {
    /// Two bodies that touch, or are no farther apart than the margin; `None` when all pairs are proven apart. Which of
    /// several is given depends on the order of the bodies alone.
    ///
    /// # Errors
    /// [`PostureError`] names the joint that is no angle. Limits of joints are not looked at.
    ///
    /// # Cost
    /// `O(log n)` for a part of `n` triangles or cells when nothing is near; one list is allocated.
    pub fn touching(&self, posture: &Posture) -> Result<Option<[&str; 2]>, PostureError> {
        posture.check(self.has_table())?;
        let poses = self.poses(posture);
        let touch = self.pairs.iter().find(|pair| !self.pair_apart(&poses, pair, self.threshold(pair)));
        Ok(touch.map(|pair| self.names_of(pair)))
    }

    /// The nearest two bodies of the pairs that are compared; `None` when there is no pair.
    ///
    /// # Errors
    /// [`PostureError`] names the joint that is no angle.
    pub fn nearest(&self, posture: &Posture) -> Result<Option<Nearest<'_>>, PostureError> {
        posture.check(self.has_table())?;
        Ok(self.nearest_within(&self.poses(posture), f64::INFINITY).map(|(_, nearest)| nearest))
    }

    /// The nearest two bodies that are less than `within` millimetres apart, and how their distance changes with the joints, by
    /// their nearest points; `None` when all pairs are farther apart. For planners that keep clear of what is near.
    ///
    /// Where another pair, or other points of the same, are as near, the derivative is that of one of them.
    ///
    /// # Errors
    /// [`PostureError`] names the joint that is no angle, or says that `within` is no number.
    ///
    /// # Cost
    /// That of [`nearest`](Self::nearest), less what lies beyond `within`.
    pub fn clearance(&self, posture: &Posture, within: f64) -> Result<Option<Clearance<'_>>, PostureError> {
        posture.check(self.has_table())?;
        if within.is_nan() {
            return Err(PostureError::Within);
        }
        let poses = self.poses(posture);
        let Some((pair, nearest)) = self.nearest_within(&poses, within) else { return Ok(None) };
        let Some([p, q]) = nearest.points else {
            return Ok(Some(Clearance { nearest, joints: [0.0; 6], table: [0.0; 2] }));
        };
        let apart = (q - p).normalize();
        let mounts = pair.map(|body| self.bodies[body].body.mount);
        let rate = |on_table: bool, k: usize| {
            let [a, b] = mounts.map(|mount| mount.is_moved_by(on_table, k));
            if a == b {
                return 0.0;
            }
            let velocity = |point| match &self.track {
                Some(track) if on_table => -track.rate(),
                _ => self.axis(&poses, on_table, k).turning(point),
            };
            if a { -velocity(&p).dot(&apart) } else { velocity(&q).dot(&apart) }
        };
        let table = if self.has_table() { [0, 1].map(|k| rate(true, k)) } else { [0.0; 2] };
        Ok(Some(Clearance { nearest, joints: [0, 1, 2, 3, 4, 5].map(|k| rate(false, k)), table }))
    }

    /// The nearest pair that is less than so far apart.
    fn nearest_within(&self, poses: &Poses, within: f64) -> Option<([usize; 2], Nearest<'_>)> {
        let gaps = self.pairs.iter().enumerate().map(|(k, pair)| (self.least_gap(poses, pair), k));
        let mut order: Vec<(f64, usize)> = gaps.filter(|(gap, _)| *gap < within).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<([usize; 2], Nearest<'_>)> = None;
        for (gap, k) in order {
            let known = best.map_or(within, |(_, best)| best.distance);
            if gap >= known || known <= 0.0 {
                break;
            }
            let pair = self.pairs[k];
            if let Some(Found { distance, points }) = self.pair_nearest(poses, &pair, known) {
                best = Some((pair, Nearest { bodies: self.names_of(&pair), distance, points }));
            }
        }
        best
    }

    pub(super) fn poses(&self, posture: &Posture) -> Poses {
        let frames = self.arm.frames(&posture.joints);
        let [tilt, turn] = posture.table;
        let on_table = |joints| self.positioner.as_ref().map_or(Isometry3::identity(), |p| p.forward(joints));
        let tables = match &self.track {
            // The ground, seen from the base.
            Some(track) => {
                [Isometry3::identity(), Translation3::from(-track.shift(tilt)).into(), Isometry3::identity()]
            }
            None => [Isometry3::identity(), on_table(&[tilt, 0.0]), on_table(&[tilt, turn])],
        };
        let count = self.bodies.len();
        let mut all = Poses {
            first: Vec::with_capacity(count),
            poses: Vec::with_capacity(count + 8),
            centers: Vec::with_capacity(count + 8),
            frames: (frames, tables),
        };
        for placed in &self.bodies {
            all.first.push(all.poses.len());
            let frame = match placed.body.mount {
                Mount::Base => &frames[0],
                Mount::Link(link) => &frames[link],
                Mount::Tilt | Mount::Ground | Mount::Rail => &tables[1],
                Mount::Table => &tables[2],
            };
            for piece in &placed.pieces {
                let pose = frame * piece.mount_piece;
                all.centers.push(pose * piece.center);
                all.poses.push(pose);
            }
        }
        all
    }

    /// Where the axis of joint `k` (counted from 0) of the arm or the table is.
    pub(super) fn axis(&self, poses: &Poses, on_table: bool, k: usize) -> Line {
        match (&self.table_chain, on_table) {
            (Some(chain), true) => chain.axis(k).placed(&poses.frames.1[k]),
            _ => self.arm_chain.axis(k).placed(&poses.frames.0[k]),
        }
    }

    /// The pieces of two bodies, each with its place in the list.
    fn meetings<'a>(&'a self, poses: &'a Poses, [a, b]: &[usize; 2]) -> impl Iterator<Item = [(usize, &'a Piece); 2]> {
        let numbered = |body: usize| (poses.first[body]..).zip(&self.bodies[body].pieces);
        let b = *b;
        numbered(*a).flat_map(move |first| numbered(b).map(move |second| [first, second]))
    }

    pub(super) fn pair_apart(&self, poses: &Poses, pair: &[usize; 2], threshold: f64) -> bool {
        let growth = self.growth(pair);
        let far = threshold + growth[0] + growth[1];
        self.meetings(poses, pair).all(|[(i, a), (j, b)]| {
            poses.gap_of_balls((i, a), (j, b)) > far || poses.meeting((i, a), (j, b)).thicker(growth).apart(threshold)
        })
    }

    fn least_gap(&self, poses: &Poses, pair: &[usize; 2]) -> f64 {
        let [grown, grown_too] = self.growth(pair);
        let gap = |[a, b]: [(usize, &Piece); 2]| poses.gap_of_balls(a, b) - grown - grown_too;
        self.meetings(poses, pair).map(gap).fold(f64::INFINITY, f64::min)
    }

    fn pair_nearest(&self, poses: &Poses, pair: &[usize; 2], known: f64) -> Option<Found> {
        let growth = self.growth(pair);
        let mut best: Option<Found> = None;
        for [(i, a), (j, b)] in self.meetings(poses, pair) {
            let known = best.map_or(known, |best| best.distance);
            if let Some(mut found) = poses.meeting((i, a), (j, b)).thicker(growth).nearest(known) {
                found.points = found.points.map(|points| points.map(|point| poses.poses[i] * point));
                best = Some(found);
            }
        }
        best
    }
}

impl Poses {
    /// No point of a body is farther from a line.
    pub(super) fn farthest(&self, body: usize, pieces: &[Piece], line: &Line) -> f64 {
        let centers = &self.centers[self.first[body]..];
        let of = |(center, piece): (&Point3<f64>, &Piece)| line.distance(center) + piece.reach + piece.radius;
        centers.iter().zip(pieces).map(of).fold(0.0, f64::max) + rounding::CHAIN_MM
    }

    /// A lower bound of the distance of two pieces, from the balls around them.
    fn gap_of_balls(&self, (i, a): (usize, &Piece), (j, b): (usize, &Piece)) -> f64 {
        let balls = a.reach + b.reach + a.radius + b.radius + rounding::CHAIN_MM;
        (self.centers[i] - self.centers[j]).norm() - balls
    }

    fn meeting<'a>(&self, (i, a): (usize, &'a Piece), (j, b): (usize, &'a Piece)) -> Meeting<'a> {
        Meeting::new(a, b, self.poses[i].inv_mul(&self.poses[j]))
    }
}
