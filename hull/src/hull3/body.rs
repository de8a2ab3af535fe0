//! The convex hull in space and its questions.
//!
//! The surface is a triangulated sphere. A body that reaches down without end has one corner at infinity, an ideal
//! point, and is a sphere all the same.

use super::parts::{Facet, IDEAL, Scratch, Undo};
use crate::error::{HullError, check};
use crate::flat;
use crate::plane::{Depth, Plane, dot};
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
    pub(super) depth: Depth,
    /// The extreme points, as long as they do not span a volume; then empty.
    pub(super) flat: Vec<[i32; 3]>,
    /// Every point that was a corner once. The first one is the ideal point, if there is one.
    pub(super) points: Vec<[i32; 3]>,
    pub(super) ideal: bool,
    /// The planes of `facets`, with gaps where a facet is gone.
    pub(super) walls: Walls,
    pub(super) facets: Vec<Facet>,
    /// The facet made last, which is there whenever the body has volume.
    pub(super) newest: u32,
    /// Facets that are gone and may be used again.
    pub(super) free: Vec<u32>,
    pub(super) journal: Vec<Undo>,
    pub(super) checkpoints: usize,
    pub(super) scratch: Scratch,
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
        let top = self.hill_climb(p, hint.facet);
        hint.facet = if self.walls.shows(top, p) { top } else { self.hill_climb(p, self.walls.first_showing(p)?) };
        Some(self.walls.plane(hint.facet))
    }

    /// The facet that `p` lies farther above (or less far below) than any of its neighbours, uphill from `start`.
    pub(super) fn hill_climb(&self, p: [i32; 3], start: u32) -> u32 {
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
}
