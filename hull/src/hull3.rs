//! The convex hull in space that grows point by point.
//!
//! C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull algorithm for convex hulls", ACM Transactions on
//! Mathematical Software 22(4), 1996: points wait in the list of a facet that they lie outside of, and the one
//! farthest out is taken next.
//! Departures: every sign is exact, so there is no tolerance and no thick facet. A facet goes when the new point lies
//! *on or* outside its plane. So all corners are extreme points of the body at any time: what is left of a
//! coplanar face is joined to the new point as a fan, and corners that no longer are any fall away.
//!
//! Why the outside lists may be handed to the new facets only: let `q` lie outside a facet that the new point `p`
//! removes, and outside one that stays. Between the two there is an edge of the horizon with `q` outside both of
//! its facets; the new facet there has a normal that is a combination of theirs with weights of at least 0, the one
//! of the facet that stays at least 0 and the other above 0, so `q` lies outside it as well.
//!
//! The surface is a triangulated sphere. A body that reaches down without end has one corner at infinity, an ideal
//! point, and is a sphere all the same.

use crate::error::{HullError, check};
use crate::flat;
use crate::plane::{Depth, Plane, cross, dot, minus};
use crate::polygon::convex_polygon;
use crate::walls::Walls;

/// A convex body spanned by lattice points, which grows as points are inserted.
///
/// # Example
/// ```
/// use curvlay_hull::{ConvexHull, Depth, Location};
/// let mut hull = ConvexHull::new(Depth::SURFACE);
/// hull.insert(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [1, 1, 1]])?;
/// assert_eq!(hull.corners().len(), 4);
/// assert_eq!(hull.locate([1, 1, 0]), Location::On);
///
/// // What if there were one more point?
/// let before = hull.checkpoint();
/// hull.insert(&[[4, 4, 4]])?;
/// assert!(matches!(hull.locate([2, 2, 2]), Location::Inside { .. }));
/// hull.rollback(before);
/// assert_eq!(hull.locate([2, 2, 2]), Location::Outside);
/// # Ok::<(), curvlay_hull::HullError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ConvexHull {
    depth: Depth,
    /// The extreme points, as long as they do not span a volume; then empty.
    flat: Vec<[i32; 3]>,
    /// Every point that was a corner once. The first one is the ideal point, if there is one.
    points: Vec<[i32; 3]>,
    ideal: bool,
    /// The planes of `facets`, with gaps where a facet is gone.
    walls: Walls,
    facets: Vec<Facet>,
    /// The facet made last, which is there whenever the body has volume.
    newest: u32,
    /// Facets that are gone and may be used again.
    free: Vec<u32>,
    journal: Vec<Undo>,
    checkpoints: usize,
    scratch: Scratch,
}

/// A triangle of the surface, counter-clockwise from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facet {
    pub(crate) corners: [u32; 3],
    /// Entry `i` is the facet across the edge from corner `i` to the next.
    pub(crate) across: [u32; 3],
}

/// Where a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Location {
    /// In the open body.
    Inside {
        /// Distance to the surface, in lattice units.
        depth: f64,
    },
    /// On the surface; also any point of a body without volume.
    On,
    /// Not in the closed body.
    Outside,
}

/// Where on the surface a search starts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hint {
    facet: u32,
}

/// A state of a hull to go back to.
#[derive(Debug)]
#[must_use = "a checkpoint is given back to `rollback` or `commit`"]
pub struct Checkpoint {
    journal: usize,
    points: usize,
    newest: u32,
}

/// What undoes one change.
#[derive(Clone, Debug)]
enum Undo {
    /// The body had no volume, and these extreme points.
    Flat(Vec<[i32; 3]>),
    Removed {
        facet: u32,
        plane: Plane,
        triangle: Facet,
    },
    Made {
        facet: u32,
        reused: bool,
    },
    Linked {
        facet: u32,
        edge: usize,
        across: u32,
    },
    Point,
}

/// Lists that are empty between calls; kept for their memory.
#[derive(Clone, Debug, Default)]
struct Scratch {
    removed: Vec<u32>,
    made: Vec<u32>,
    horizon: Vec<HorizonEdge>,
    /// For each point: the new facet whose edge on the horizon starts there.
    starting_at: Vec<u32>,
    /// For each facet: the first point that waits outside it.
    waiting: Vec<u32>,
}

/// An edge between what a new point removes and what stays.
#[derive(Clone, Copy, Debug)]
struct HorizonEdge {
    from: u32,
    to: u32,
    stays: u32,
    edge_there: usize,
}

/// No facet, no point.
const NONE: u32 = u32::MAX;

/// The ideal point in `points`; its coordinates are a direction.
const IDEAL: u32 = 0;
const DOWN: [i32; 3] = [0, 0, -1];

impl ConvexHull {
    /// An empty body. `depth` says from where on [`ConvexHull::is_deep`] counts a point as deep.
    pub fn new(depth: Depth) -> Self {
        ConvexHull {
            depth,
            flat: Vec::new(),
            points: Vec::new(),
            ideal: false,
            walls: Walls::default(),
            facets: Vec::new(),
            newest: 0,
            free: Vec::new(),
            journal: Vec::new(),
            checkpoints: 0,
            scratch: Scratch::default(),
        }
    }

    /// The column that reaches from the plane `z = top` down without end and whose cross-section is the hull of
    /// `section`. Whatever is inserted later gets a column below it too.
    ///
    /// # Errors
    /// [`HullError::NoArea`] if `section` lies on a line, [`HullError::OutOfReach`] for large coordinates.
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::{ConvexHull, Depth, Location};
    /// let column = ConvexHull::column(&[[0, 0], [8, 0], [8, 8], [0, 8]], 0, Depth::SURFACE)?;
    /// assert_eq!(column.locate([4, 4, -100]), Location::Inside { depth: 4.0 });
    /// assert_eq!(column.locate([4, 4, 1]), Location::Outside);
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn column(section: &[[i32; 2]], top: i32, depth: Depth) -> Result<Self, HullError> {
        check(section)?;
        check(&[[top]])?;
        let section = convex_polygon(section);
        if section.len() < 3 {
            return Err(HullError::NoArea);
        }
        let count = section.len() as u32;
        let mut hull = ConvexHull { ideal: true, ..ConvexHull::new(depth) };
        hull.points.push(DOWN);
        hull.points.extend(section.iter().map(|&[x, y]| [x, y, top]));
        let lid = (2..count).map(|k| [1, k, k + 1]);
        let walls = (1..=count).map(|k| [k % count + 1, k, IDEAL]);
        hull.build(lid.chain(walls).collect());
        Ok(hull)
    }

    /// Inserts points, in one batch, and says how many of them extended the body.
    ///
    /// The body does not depend on the order of the points or on how they are split into batches, and neither
    /// do [`ConvexHull::corners`] and [`ConvexHull::faces`]. How a face with more than three corners is cut into
    /// triangles does.
    ///
    /// # Errors
    /// [`HullError::OutOfReach`] for a coordinate beyond [`crate::MAX_COORDINATE`]; then nothing was inserted.
    ///
    /// # Cost
    /// For `n` points and `f` facets at most `O(n f)`, and far less for points outside, since those near each other
    /// mostly see the same facet.
    pub fn insert(&mut self, points: &[[i32; 3]]) -> Result<usize, HullError> {
        check(points)?;
        let corners_before = self.points.len();
        if self.is_solid() {
            self.insert_outside(points);
            return Ok(self.points.len() - corners_before);
        }
        let all: Vec<_> = self.flat.iter().chain(points).copied().collect();
        let before = std::mem::take(&mut self.flat);
        match flat::tetrahedron(&all) {
            None => {
                self.flat = flat::extreme_points(&all);
                let extended = self.flat.iter().filter(|corner| !before.contains(corner)).count();
                self.log(Undo::Flat(before));
                Ok(extended)
            }
            Some(first) => {
                self.log(Undo::Flat(before.clone()));
                self.points.extend(first);
                self.build(vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]);
                self.insert_outside(&all);
                Ok(self.points.iter().filter(|corner| !before.contains(corner)).count())
            }
        }
    }

    /// Whether the body has volume.
    pub fn is_solid(&self) -> bool {
        !self.facets.is_empty()
    }

    /// The depth from which a point counts as deep.
    pub fn depth(&self) -> Depth {
        self.depth
    }

    /// Where `p` lies. Exact within [`crate::MAX_COORDINATE`], but for the figure of the depth.
    ///
    /// # Cost
    /// One pass over the facets.
    pub fn locate(&self, p: [i32; 3]) -> Location {
        if !self.is_solid() {
            return if flat::contains(&self.flat, p) { Location::On } else { Location::Outside };
        }
        let mut depth = f64::INFINITY;
        let mut on = false;
        if self.walls.first_below(p).is_some() {
            return Location::Outside;
        }
        for facet in self.walls.live() {
            let height = self.walls.distance(facet, p);
            on |= height >= 0.0;
            depth = depth.min(-height);
        }
        if on { Location::On } else { Location::Inside { depth } }
    }

    /// Whether `p` lies in the closed body, at least [`ConvexHull::depth`] below every plane of its surface. Exact
    /// within [`crate::MAX_COORDINATE`].
    pub fn is_deep(&self, p: [i32; 3]) -> bool {
        if !self.is_solid() {
            return self.depth == Depth::SURFACE && flat::contains(&self.flat, p);
        }
        self.walls.first_showing(p).is_none()
    }

    /// Whether `p` lies outside the closed body, so that inserting it would extend the body. Exact.
    ///
    /// `hint` is as in [`ConvexHull::witness`], and so is the cost: long if the answer is no.
    pub fn is_outside(&self, p: [i32; 3], hint: &mut Hint) -> bool {
        if !self.is_solid() {
            return !flat::contains(&self.flat, p);
        }
        let below = self.facet_below(p, hint.facet);
        hint.facet = below.unwrap_or(hint.facet);
        below.is_some()
    }

    /// A plane of the surface that shows that `p` is not deep; `None` if it is.
    ///
    /// Starting from `hint`, which is left where the search ended, it walks over the surface to where `p` lies farthest above: such a plane goes on
    /// to show it the longest while the body grows. Points near each other share a hint well; any hint will do.
    ///
    /// # Cost
    /// A short walk as a rule, one pass over the facets at worst (and if `p` is deep).
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::{ConvexHull, Depth, Hint};
    /// let column = ConvexHull::column(&[[0, 0], [8, 0], [8, 8], [0, 8]], 0, Depth::new(2.0)?)?;
    /// let mut hint = Hint::default();
    /// let mut normal = |p| column.witness(p, &mut hint).map(|plane| plane.reduced().normal);
    /// assert_eq!(normal([7, 4, 5]), Some([0, 0, 1]));
    /// assert_eq!(normal([7, 4, -5]), Some([1, 0, 0]));
    /// assert_eq!(normal([4, 4, -5]), None);
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn witness(&self, p: [i32; 3], hint: &mut Hint) -> Option<Plane> {
        if !self.is_solid() {
            return None;
        }
        let top = self.climb(p, hint.facet);
        hint.facet = if self.walls.shows(top, p) { top } else { self.climb(p, self.walls.first_showing(p)?) };
        Some(self.walls.plane(hint.facet))
    }

    /// The facet that `p` lies farther above (or less far below) than any of its neighbours, uphill from `start`.
    fn climb(&self, p: [i32; 3], start: u32) -> u32 {
        let mut top = if self.walls.is_live(start) { start } else { self.newest };
        let mut height_of_top = self.walls.distance(top, p);
        loop {
            let below = top;
            for next in self.facets[below as usize].across {
                let height_of_next = self.walls.distance(next, p);
                if height_of_next > height_of_top {
                    (top, height_of_top) = (next, height_of_next);
                }
            }
            if top == below {
                return top;
            }
        }
    }

    /// The greatest `direction . p` in the body; `None` if there is no point, or no greatest value.
    pub fn support(&self, direction: [i32; 3]) -> Option<i64> {
        let direction = direction.map(i64::from);
        if self.ideal && dot(direction, DOWN) > 0 {
            return None;
        }
        self.corners().into_iter().map(|corner| dot(direction, corner)).max()
    }

    /// The planes of the facets. Triangles of one face each have their own multiple of the same normal.
    pub fn planes(&self) -> impl Iterator<Item = Plane> {
        self.walls.live().map(|facet| self.walls.plane(facet))
    }

    /// The corners of the body (its extreme points) in lexical order.
    pub fn corners(&self) -> Vec<[i32; 3]> {
        let mut corners = self.flat.clone();
        corners.extend(self.triangles().flatten().flatten());
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The triangles of the surface, counter-clockwise from outside. A corner at infinity is `None`.
    pub fn triangles(&self) -> impl Iterator<Item = [Option<[i32; 3]>; 3]> {
        self.facets().map(|facet| self.facet(facet).corners.map(|corner| self.finite(corner)))
    }

    pub(crate) fn facets(&self) -> impl Iterator<Item = u32> {
        self.walls.live()
    }

    pub(crate) fn plane_of(&self, facet: u32) -> Plane {
        self.walls.plane(facet)
    }

    pub(crate) fn facet(&self, facet: u32) -> Facet {
        self.facets[facet as usize]
    }

    /// The corner, unless it is the ideal point.
    pub(crate) fn finite(&self, corner: u32) -> Option<[i32; 3]> {
        (!self.ideal || corner != IDEAL).then(|| self.points[corner as usize])
    }

    // Going back -------------------------------------------------------------------------------------------------

    /// Starts a what-if: everything from here on can be taken back. What-ifs may be nested.
    pub fn checkpoint(&mut self) -> Checkpoint {
        self.checkpoints += 1;
        Checkpoint { journal: self.journal.len(), points: self.points.len(), newest: self.newest }
    }

    /// Takes back everything since `checkpoint`, exactly. Costs as much as was changed.
    pub fn rollback(&mut self, checkpoint: Checkpoint) {
        while self.journal.len() > checkpoint.journal {
            match self.journal.pop() {
                Some(Undo::Point) => {
                    self.points.pop();
                }
                Some(Undo::Linked { facet, edge, across }) => self.facets[facet as usize].across[edge] = across,
                Some(Undo::Removed { facet, plane, triangle }) => {
                    self.walls.set(facet, &plane);
                    self.facets[facet as usize] = triangle;
                    self.free.pop();
                }
                Some(Undo::Made { facet, reused: true }) => {
                    self.walls.take(facet);
                    self.free.push(facet);
                }
                Some(Undo::Made { reused: false, .. }) => {
                    self.walls.pop();
                    self.facets.pop();
                }
                Some(Undo::Flat(flat)) => {
                    self.flat = flat;
                    self.points.clear();
                    self.walls.clear();
                    self.facets.clear();
                    self.free.clear();
                }
                None => break,
            }
        }
        self.newest = checkpoint.newest;
        self.checkpoints -= 1;
    }

    /// Ends the what-if that `checkpoint` began, and keeps what was inserted.
    pub fn commit(&mut self, checkpoint: Checkpoint) {
        let Checkpoint { .. } = checkpoint;
        self.checkpoints -= 1;
        if self.checkpoints == 0 {
            self.journal.clear();
        }
    }

    /// The points inserted since `checkpoint` that extended the body when they came; later ones may have covered them.
    /// Points count from when the body has volume: until then there are none, and those that give it volume are all
    /// in the answer.
    pub fn added_since(&self, checkpoint: &Checkpoint) -> &[[i32; 3]] {
        &self.points[checkpoint.points.min(self.points.len())..]
    }

    fn log(&mut self, undo: Undo) {
        if self.checkpoints > 0 {
            self.journal.push(undo);
        }
    }

    // Growing ----------------------------------------------------------------------------------------------------

    /// Makes the surface of the given triangles, which form a closed one.
    fn build(&mut self, triangles: Vec<[u32; 3]>) {
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for (facet, corners) in triangles.iter().enumerate() {
            let made = self.new_facet(Facet { corners: *corners, across: [NONE; 3] });
            debug_assert_eq!(made as usize, facet);
            edges.extend((0..3).map(|k| ([corners[k], corners[(k + 1) % 3]], made, k)));
        }
        edges.sort_unstable();
        for &([a, b], facet, k) in &edges {
            let twin = edges.binary_search_by_key(&[b, a], |edge| edge.0);
            self.facets[facet as usize].across[k] = twin.map_or(NONE, |at| edges[at].1);
        }
    }

    /// Inserts those of `points` that lie outside, the body being solid.
    fn insert_outside(&mut self, points: &[[i32; 3]]) {
        let mut waiting = std::mem::take(&mut self.scratch.waiting);
        waiting.clear();
        waiting.resize(self.facets.len(), NONE);
        let mut next = vec![NONE; points.len()];
        let mut pending = Vec::new();
        let mut orphans = Vec::new();
        let mut hint = 0;
        for (at, &point) in points.iter().enumerate() {
            if let Some(facet) = self.facet_below(point, hint) {
                hint = facet;
                let first = &mut waiting[facet as usize];
                if *first == NONE {
                    pending.push(facet);
                }
                next[at] = std::mem::replace(first, at as u32);
            }
        }
        while let Some(facet) = pending.pop() {
            let first = std::mem::replace(&mut waiting[facet as usize], NONE);
            if first == NONE {
                continue;
            }
            let plane = self.walls.plane(facet);
            let farthest = chain(&next, first).max_by_key(|&at| (plane.height(points[at]), at)).unwrap_or(0);
            self.add(points[farthest], facet);
            waiting.resize(self.facets.len(), NONE);
            waiting[facet as usize] = first;
            orphans.clear();
            orphans
                .extend(self.scratch.removed.iter().map(|&gone| std::mem::replace(&mut waiting[gone as usize], NONE)));
            for &first in &orphans {
                let mut at = first;
                while at != NONE {
                    let point = points[at as usize];
                    let after = next[at as usize];
                    let outside = |made: &&u32| self.walls.height(**made, point) > 0.0;
                    if let Some(&made) = self.scratch.made.iter().find(outside) {
                        next[at as usize] = std::mem::replace(&mut waiting[made as usize], at);
                    }
                    at = after;
                }
            }
            pending.extend(self.scratch.made.iter().filter(|&&made| waiting[made as usize] != NONE));
        }
        self.scratch.waiting = waiting;
    }

    /// A facet that `p` lies strictly outside of. `hint` is looked at first.
    fn facet_below(&self, p: [i32; 3], hint: u32) -> Option<u32> {
        let top = self.climb(p, hint);
        if self.walls.height(top, p) > 0.0 { Some(top) } else { self.walls.first_below(p) }
    }

    /// Adds the corner `p`, which lies strictly outside the facet `seed`.
    fn add(&mut self, p: [i32; 3], seed: u32) {
        let apex = self.points.len() as u32;
        self.points.push(p);
        self.log(Undo::Point);
        self.scratch.starting_at.resize(self.points.len(), NONE);
        self.remove_seen(p, seed);
        self.scratch.made.clear();
        for at in 0..self.scratch.horizon.len() {
            let HorizonEdge { from, to, stays, edge_there } = self.scratch.horizon[at];
            let made = self.new_facet(Facet { corners: [from, to, apex], across: [stays, NONE, NONE] });
            self.log(Undo::Linked { facet: stays, edge: edge_there, across: self.facet(stays).across[edge_there] });
            self.facets[stays as usize].across[edge_there] = made;
            self.scratch.starting_at[from as usize] = made;
            self.scratch.made.push(made);
        }
        for &made in &self.scratch.made {
            let next = self.scratch.starting_at[self.facets[made as usize].corners[1] as usize];
            self.facets[made as usize].across[1] = next;
            self.facets[next as usize].across[2] = made;
        }
    }

    /// Removes the facets that have `p` on their plane or outside, which hang together and contain `seed`, and
    /// leaves their border in `scratch.horizon`.
    fn remove_seen(&mut self, p: [i32; 3], seed: u32) {
        self.scratch.removed.clear();
        self.scratch.horizon.clear();
        self.remove(seed);
        let mut done = 0;
        while done < self.scratch.removed.len() {
            let gone = self.scratch.removed[done];
            let Facet { corners, across } = self.facets[gone as usize];
            done += 1;
            for k in 0..3 {
                let beyond = across[k];
                if !self.walls.is_live(beyond) {
                    continue;
                }
                if self.walls.height(beyond, p) >= 0.0 {
                    self.remove(beyond);
                } else {
                    let (from, to) = (corners[k], corners[(k + 1) % 3]);
                    // Across the edge the same two corners come the other way round.
                    let theirs = self.facets[beyond as usize].corners;
                    let edge_there = (0..3).find(|&e| theirs[e] == to).unwrap_or(0);
                    self.scratch.horizon.push(HorizonEdge { from, to, stays: beyond, edge_there });
                }
            }
        }
    }

    fn remove(&mut self, facet: u32) {
        let plane = self.walls.take(facet);
        self.log(Undo::Removed { facet, plane, triangle: self.facets[facet as usize] });
        self.free.push(facet);
        self.scratch.removed.push(facet);
    }

    fn new_facet(&mut self, facet: Facet) -> u32 {
        let plane = self.plane_through(facet.corners);
        let (made, reused) = match self.free.pop() {
            Some(slot) => {
                self.walls.set(slot, &plane);
                self.facets[slot as usize] = facet;
                (slot, true)
            }
            None => {
                self.walls.push(&plane);
                self.facets.push(facet);
                (self.facets.len() as u32 - 1, false)
            }
        };
        self.log(Undo::Made { facet: made, reused });
        self.newest = made;
        made
    }

    fn plane_through(&self, corners: [u32; 3]) -> Plane {
        let ideal_at = if self.ideal { corners.iter().position(|&c| c == IDEAL) } else { None };
        let turn = ideal_at.map_or(0, |at| at + 1);
        let [a, b, c] = [0, 1, 2].map(|k| self.points[corners[(k + turn) % 3] as usize]);
        let to_c = if ideal_at.is_some() { c.map(i64::from) } else { minus(c, a) };
        Plane::through(cross(minus(b, a), to_c), a, self.depth)
    }
}

/// The list that starts at `first`.
fn chain(next: &[u32], first: u32) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(first as usize), |&at| Some(next[at] as usize).filter(|&at| at != NONE as usize))
}
