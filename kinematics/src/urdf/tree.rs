//! Links and joints as a tree, and which of them are the arm.

use super::error::UrdfError;
use super::file::{File, Joint, Kind};
use nalgebra::Isometry3;
use std::collections::BTreeMap;

/// Which links are base and flange; what is `None` is looked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinkNames {
    /// The link whose frame is the base. Default: `base` where that is fixed to the root (in the packages of ROS-Industrial it is the frame in
    /// which the maker's controller counts), else the root.
    pub base: Option<String>,
    /// The link whose frame is the flange. Default: `tool0`, else `flange`, if six joints turn before it; else the last of the chain of six joints.
    pub flange: Option<String>,
}

/// The names of links, and the joint above each that has one.
pub(super) struct Tree<'a> {
    file: &'a File,
    above: BTreeMap<&'a str, &'a Joint>,
    root: &'a str,
}

/// What the frames of base and flange are called, the base in the root, and the joints from the root to the flange.
pub(super) struct Path<'a> {
    pub base: &'a str,
    pub flange: &'a str,
    pub root_base: Isometry3<f64>,
    pub joints: Vec<&'a Joint>,
}

/// Joints of an arm.
const JOINTS: usize = 6;

impl<'a> Tree<'a> {
    pub fn new(file: &'a File) -> Result<Self, UrdfError> {
        let mut above: BTreeMap<&str, &Joint> = BTreeMap::new();
        for joint in &file.joints {
            if let Some(first) = above.insert(&joint.child, joint) {
                let (first, second) = (first.name.clone(), joint.name.clone());
                return Err(UrdfError::ClosedChain { link: joint.child.clone(), first, second });
            }
        }
        if file.joints.is_empty() {
            return Err(UrdfError::NoJoints);
        }
        let mut roots = file.links.iter().map(String::as_str).filter(|link| !above.contains_key(link));
        let circle = || UrdfError::Circle { link: file.joints[0].child.clone() };
        let root = roots.next().ok_or_else(circle)?;
        if let Some(second) = roots.next() {
            return Err(UrdfError::TwoRoots { first: root.into(), second: second.into() });
        }
        let tree = Tree { file, above, root };
        for link in &file.links {
            tree.joints_to(link)?;
        }
        Ok(tree)
    }

    /// The joints from the root to a link.
    fn joints_to(&self, link: &str) -> Result<Vec<&'a Joint>, UrdfError> {
        let mut joints = Vec::new();
        let mut at = link;
        while let Some(joint) = self.above.get(at) {
            joints.push(*joint);
            if joints.len() > self.file.joints.len() {
                return Err(UrdfError::Circle { link: link.into() });
            }
            at = &joint.parent;
        }
        joints.reverse();
        Ok(joints)
    }

    fn named(&self, link: &str) -> Result<&'a str, UrdfError> {
        let found = self.file.links.iter().find(|known| *known == link);
        found.map(String::as_str).ok_or_else(|| UrdfError::NoLink { link: link.into() })
    }

    /// The part of the tree that is the arm.
    pub fn path(&self, names: &LinkNames) -> Result<Path<'a>, UrdfError> {
        let base = match &names.base {
            Some(link) => self.named(link)?,
            None => self.usual_base()?,
        };
        let above_base = self.joints_to(base)?;
        if let Some(joint) = above_base.iter().find(|joint| joint.kind != Kind::Fixed) {
            return Err(UrdfError::BaseMoves { link: base.into(), joint: joint.name.clone() });
        }
        let root_base = above_base.iter().fold(Isometry3::identity(), |pose, joint| pose * joint.origin);
        let flange = match &names.flange {
            Some(link) => self.named(link)?,
            None => self.usual_flange(base)?,
        };
        let joints = self.joints_to(flange)?;
        for joint in &joints {
            if let Some(of) = &joint.mimics {
                return Err(UrdfError::Mimic { joint: joint.name.clone(), of: of.clone() });
            }
            if let Kind::Other(kind) = &joint.kind {
                return Err(UrdfError::OtherJoint { joint: joint.name.clone(), kind: kind.clone() });
            }
        }
        let found = turning(&joints);
        if found != JOINTS {
            return Err(not_six(base, flange, found));
        }
        Ok(Path { base, flange, root_base, joints })
    }

    fn usual_base(&self) -> Result<&'a str, UrdfError> {
        let Ok(base) = self.named("base") else { return Ok(self.root) };
        let is_fixed = self.joints_to(base)?.iter().all(|joint| joint.kind == Kind::Fixed);
        Ok(if is_fixed { base } else { self.root })
    }

    fn usual_flange(&self, base: &str) -> Result<&'a str, UrdfError> {
        for name in ["tool0", "flange"] {
            let Ok(link) = self.named(name) else { continue };
            // What moves may be no turning joint: then the path says so.
            if self.joints_to(link)?.iter().filter(|joint| joint.kind != Kind::Fixed).count() == JOINTS {
                return Ok(link);
            }
        }
        // The links that the last of six joints turns, and the one behind the most joints.
        let mut ends: Vec<&str> = Vec::new();
        let (mut longest, mut most) = (self.root, 0);
        for link in &self.file.links {
            let joints = self.joints_to(link)?;
            let moves = |joint: &&&Joint| joint.kind != Kind::Fixed && joint.mimics.is_none();
            let count = joints.iter().filter(moves).count();
            if count > most {
                (longest, most) = (link, count);
            }
            if count == JOINTS && joints.last().is_some_and(|joint| joint.kind != Kind::Fixed && joint.mimics.is_none())
            {
                ends.push(link);
            }
        }
        match (most > JOINTS, &ends[..]) {
            (false, [end]) => Ok(end),
            (false, [first, second, ..]) => {
                Err(UrdfError::SeveralArms { first: (*first).into(), second: (*second).into() })
            }
            // A chain of other joints says so itself.
            (false, []) if most == JOINTS || turning(&self.joints_to(longest)?) < most => Ok(longest),
            _ => Err(not_six(base, longest, most)),
        }
    }
}

fn turning(joints: &[&Joint]) -> usize {
    joints.iter().filter(|joint| matches!(joint.kind, Kind::Turning(..)) && joint.mimics.is_none()).count()
}

fn not_six(base: &str, flange: &str, found: usize) -> UrdfError {
    let hint = if found > JOINTS { "; if the arm ends before, name the link of its flange" } else { "" };
    UrdfError::NotSix { base: base.into(), flange: flange.into(), found, hint }
}
