//! Pieces of bodies: convex ones, triangles and cells, seen alike as trees of boxes with few-cornered hulls at the
//! leaves.

use super::bounds::Aabb;
use super::cells::{self, CellTree};
use super::mesh::MeshTree;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

#[derive(Clone, Debug)]
pub(super) enum Form {
    /// The hull of some points, and their box.
    Convex(Vec<Point3<f64>>, Aabb),
    Mesh(MeshTree),
    Cells(CellTree),
}

/// A node of the tree of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) enum Node {
    Whole,
    Mesh(u32),
    Cells(cells::Node),
}

/// The corners of a leaf.
pub(super) enum Corners<'a> {
    Stored(&'a [Point3<f64>]),
    Box([Point3<f64>; 8]),
}

impl Corners<'_> {
    pub fn points(&self) -> &[Point3<f64>] {
        match self {
            Corners::Stored(points) => points,
            Corners::Box(points) => points,
        }
    }
}

/// A form, grown by a ball.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub form: Form,
    pub radius: f64,
    /// Where it is on what it is mounted on.
    pub mount_piece: Isometry3<f64>,
    /// A ball around it, in its own frame.
    pub center: Point3<f64>,
    pub reach: f64,
}

impl Piece {
    pub fn new(form: Form, radius: f64, mount_piece: Isometry3<f64>) -> Self {
        let mut piece = Piece { form, radius, mount_piece, center: Point3::origin(), reach: 0.0 };
        let bounds = piece.root().map_or(Aabb::of(&[Point3::origin()]), |root| piece.bounds(&root));
        piece.center = bounds.center;
        piece.reach = piece.farthest(|point| (point - bounds.center).norm());
        piece
    }

    pub fn hull(points: Vec<Point3<f64>>, radius: f64, mount_piece: Isometry3<f64>) -> Self {
        let bounds = Aabb::of(&points);
        Piece::new(Form::Convex(points, bounds), radius, mount_piece)
    }

    /// A capsule lies along x of its own frame, so that its box has no thickness.
    pub fn capsule(from: &Point3<f64>, to: &Point3<f64>, radius: f64, mount_body: &Isometry3<f64>) -> Self {
        let along = to - from;
        let half = 0.5 * along.norm();
        let turn = UnitQuaternion::rotation_between(&Vector3::x(), &along)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
        let frame = Isometry3::from_parts(nalgebra::center(from, to).into(), turn);
        let points = vec![Point3::new(-half, 0.0, 0.0), Point3::new(half, 0.0, 0.0)];
        Piece::hull(points, radius, mount_body * frame)
    }

    /// `None` when there is nothing in it.
    pub fn root(&self) -> Option<Node> {
        match &self.form {
            Form::Convex(..) => Some(Node::Whole),
            Form::Mesh(_) => Some(Node::Mesh(0)),
            Form::Cells(cells) => (!cells.is_empty()).then(|| Node::Cells(cells.root())),
        }
    }

    pub fn bounds(&self, node: &Node) -> Aabb {
        match (&self.form, node) {
            (Form::Mesh(mesh), Node::Mesh(node)) => mesh.bounds(*node),
            (Form::Cells(cells), Node::Cells(node)) => cells.bounds(node),
            (Form::Convex(_, bounds), _) => *bounds,
            _ => unreachable!("a node of another piece"),
        }
    }

    pub fn is_leaf(&self, node: &Node) -> bool {
        match (&self.form, node) {
            (Form::Mesh(mesh), Node::Mesh(node)) => mesh.children(*node).is_none(),
            (Form::Cells(cells), Node::Cells(node)) => cells.is_leaf(node),
            _ => true,
        }
    }

    /// The children of a node that is no leaf: how many, and they.
    pub fn children(&self, node: &Node) -> (usize, [Node; 8]) {
        let mut children = [Node::Whole; 8];
        let mut count = 0;
        match (&self.form, node) {
            (Form::Mesh(mesh), Node::Mesh(node)) => {
                for child in mesh.children(*node).into_iter().flatten() {
                    children[count] = Node::Mesh(child);
                    count += 1;
                }
            }
            (Form::Cells(cells), Node::Cells(node)) => {
                for child in cells.children(node) {
                    children[count] = Node::Cells(child);
                    count += 1;
                }
            }
            _ => {}
        }
        (count, children)
    }

    pub fn corners(&self, leaf: &Node) -> Corners<'_> {
        match (&self.form, leaf) {
            (Form::Mesh(mesh), Node::Mesh(leaf)) => Corners::Stored(mesh.corners(*leaf)),
            (Form::Convex(points, _), _) => Corners::Stored(points),
            _ => Corners::Box(self.bounds(leaf).corners()),
        }
    }

    /// The greatest value of a convex function on it, the radius not counted; of cells, on the box of the grid.
    pub fn farthest(&self, measure: impl Fn(&Point3<f64>) -> f64) -> f64 {
        let greatest = |points: &[Point3<f64>]| points.iter().map(&measure).fold(f64::NEG_INFINITY, f64::max);
        match &self.form {
            Form::Convex(points, _) => greatest(points),
            Form::Mesh(mesh) => greatest(mesh.triangles().as_flattened()),
            Form::Cells(cells) => greatest(&cells.bounds(&cells.root()).corners()),
        }
    }
}
