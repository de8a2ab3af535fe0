//! Whether a point lies at least `eps` deep in the hull of a [`Body`], decided exactly.
//!
//! For any integer direction `n` let `off(n)` be the largest `n.p` over the body. No point `c` of the hull is deeper
//! than `(off(n) - n.c) / |n|` half cells, so a direction with `off(n) - n.c < 2 eps |n|` (`<=` where a point at that depth is not
//! inside) is a *witness* that `c` is not inside. Directions that were witnesses once are kept, with their offsets up to date, and neighbouring points
//! mostly share one. When none of them will do, a coarse hull of a few points of the body is refined where it passes
//! too near to `c`: each of its facets that comes nearer than `eps` gets the body's farthest point in the direction of
//! its normal, until that direction turns out to be a witness, or no facet comes near. The coarse hull is part of the
//! true one, so then `c` is inside. All numbers are integers; squares take 128 bits.

use super::body::Body;
use super::vec3::{Vec3, dot};
use super::wrap::facet_normals;
use crate::curved::{Platform, Rules, RulesError};

/// Points of the coarse hull above which it is started afresh: it costs the square of their number to wrap.
const COARSE_POINTS: usize = 96;

/// Layers for which a direction is kept after it was last of use.
const KEPT_LAYERS: u32 = 8;

/// What "inside" means.
#[derive(Clone, Copy)]
pub(super) struct Question {
    /// Depth from which a point is inside, in 1/1024 of a cell.
    pub(super) inside_depth: u32,
    /// Whether a point at exactly that depth is inside.
    pub(super) closed: bool,
    /// Hulls are hulls in the plane of x and z.
    pub(super) flat: bool,
    /// The hull reaches down without end.
    pub(super) reaches_down: bool,
}

impl Question {
    /// That of the rules.
    pub(super) fn of(rules: &Rules, platform: &Platform) -> Result<Self, RulesError> {
        let (inside_depth, closed, flat) = (rules.inside_depth_in_1024ths()?, rules.boundary_is_inside, rules.flat);
        Ok(Question { inside_depth, closed, flat, reaches_down: platform.reaches_down() })
    }

    /// Whether the hull can be bounded in the direction `n`.
    fn bounds(&self, n: Vec3) -> bool {
        !(self.reaches_down && n[2] < 0)
    }

    /// The least integer that is not below `2 eps |n|`, or the least above it if a point at that depth is not inside.
    fn margin(&self, n: Vec3) -> i64 {
        let norm2: u128 = n.iter().map(|&x| u128::from(x.unsigned_abs()).pow(2)).sum();
        let square = u128::from(self.inside_depth).pow(2) * norm2; // (1024 eps |n|)^2
        // The integer root rounds down; the margin must not be too small, so where points at that depth are inside it is rounded up. `1024
        // eps |n|` over 512 is `2 eps |n|`, in half cells.
        let root = square.isqrt();
        match self.closed {
            true => (root + u128::from(root * root < square)).div_ceil(512) as i64,
            false => (root / 512 + 1) as i64,
        }
    }
}

/// A direction and how far the body reaches along it.
struct Witness {
    n: Vec3,
    offset: i64,
    margin: i64,
    /// The last layer in which it was of use.
    used: u32,
}

impl Witness {
    fn clears(&self, c: Vec3) -> bool {
        dot(self.n, c) > self.offset - self.margin
    }
}

/// Answers the question for one point after another while the body grows.
pub(super) struct Depths {
    question: Question,
    layer: u32,
    /// The first [`Depths::fixed`] of them stay for good.
    witnesses: Vec<Witness>,
    fixed: usize,
    /// The witness that served last.
    last: usize,
    /// Points of the body, and the facets of their hull with offsets of that hull.
    coarse: Vec<Vec3>,
    facets: Vec<Witness>,
}

impl Depths {
    pub(super) fn new(question: Question, body: &Body) -> Self {
        let mut depths = Depths {
            question,
            layer: 0,
            witnesses: Vec::new(),
            fixed: 0,
            last: 0,
            coarse: Vec::new(),
            facets: Vec::new(),
        };
        for n in compass(question) {
            depths.remember(n, body.support(n).0);
        }
        depths.fixed = depths.witnesses.len();
        depths
    }

    /// Takes note that a layer was added to the body, on the given levels.
    pub(super) fn body_grew(&mut self, body: &Body, levels: &[usize]) {
        self.layer += 1;
        let oldest = self.layer.saturating_sub(KEPT_LAYERS);
        let mut place = 0..;
        let fixed = self.fixed;
        self.witnesses.retain(|witness| place.next() < Some(fixed) || witness.used >= oldest);
        // Offsets only grow, so those of levels that did not change hold on.
        for witness in &mut self.witnesses {
            witness.offset = body.raised(witness.n, witness.offset, levels);
        }
        self.last = 0;
    }

    /// Whether `c` lies in the hull of the body at least `eps` deep.
    pub(super) fn is_inside(&mut self, body: &Body, c: Vec3) -> bool {
        let clears = |witness: &Witness| witness.clears(c);
        if self.witnesses.get(self.last).is_some_and(clears) {
            return false;
        }
        if let Some(at) = self.witnesses.iter().position(clears) {
            self.witnesses[at].used = self.layer;
            self.last = at;
            return false;
        }
        // The coarse hull is part of the body's: deep in it is deep in the body.
        if !self.facets.is_empty() && !self.facets.iter().any(clears) {
            return true;
        }
        self.refine(body, c)
    }

    fn remember(&mut self, n: Vec3, offset: i64) {
        self.last = self.witnesses.len();
        self.witnesses.push(Witness { n, offset, margin: self.question.margin(n), used: self.layer });
    }

    /// Refines the coarse hull around `c` until it is known whether `c` is inside.
    fn refine(&mut self, body: &Body, c: Vec3) -> bool {
        if self.coarse.is_empty() || self.coarse.len() > COARSE_POINTS {
            self.coarse = body.platform_triangle().to_vec();
            self.coarse.extend(compass(self.question).map(|n| body.support(n).1));
            self.wrap();
        }
        loop {
            let mut near = false;
            for at in 0..self.facets.len() {
                if self.facets[at].clears(c) {
                    near = true;
                    let n = self.facets[at].n;
                    let (offset, point) = body.support(n);
                    // With the body's own offset the direction is a witness. Else the body has a point beyond this facet, and the coarse
                    // hull gets nearer to it.
                    if dot(n, c) > offset - self.facets[at].margin {
                        self.remember(n, offset);
                        self.wrap();
                        return false;
                    }
                    self.coarse.push(point);
                }
            }
            if !near {
                return true;
            }
            self.wrap();
        }
    }

    /// How deep `c`, a point of the hull, lies in it, in cells: the least distance from a supporting plane.
    pub(super) fn depth(&mut self, body: &Body, c: Vec3) -> f64 {
        let distance = |n: Vec3, offset: i64| {
            let norm = n.map(|x| x as f64).iter().map(|x| x * x).sum::<f64>().sqrt();
            (offset - dot(n, c)) as f64 / norm / 2.0
        };
        let mut least = f64::INFINITY;
        loop {
            let points = self.coarse.len();
            for facet in &self.facets {
                // A facet of the coarse hull that is farther away than the nearest plane of the body so far cannot hide a nearer one.
                if distance(facet.n, facet.offset) < least {
                    let (offset, point) = body.support(facet.n);
                    least = least.min(distance(facet.n, offset));
                    if offset > facet.offset {
                        self.coarse.push(point);
                    }
                }
            }
            if self.coarse.len() == points {
                return least;
            }
            self.wrap();
        }
    }

    fn wrap(&mut self) {
        let Question { flat, .. } = self.question;
        let mut normals = facet_normals(&mut self.coarse, flat);
        normals.retain(|&n| self.question.bounds(n));
        self.facets.clear();
        for n in normals {
            let offset = self.coarse.iter().map(|&point| dot(n, point)).max().unwrap_or(0);
            self.facets.push(Witness { n, offset, margin: self.question.margin(n), used: 0 });
        }
    }
}

/// Of the directions to the 26 neighbours of a cell those that the question allows.
fn compass(question: Question) -> impl Iterator<Item = Vec3> {
    let all = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    all.filter(move |&n| n != [0; 3] && question.bounds(n) && !(question.flat && n[1] != 0))
}
