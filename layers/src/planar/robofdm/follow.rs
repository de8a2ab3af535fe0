//! The planes of a sequence on the solid: each is perturbed, and cuts the section that it was made for (section 2.4.3).

use super::error::RoboFdmError;
use super::random::Random;
use super::risk::RiskModel;
use super::sequence::BuildSequence;
use super::state::{Node, State};
use crate::planar::solid::Wall;
use crate::planar::{CutPlane, Partition};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is left of a cell, what was taken off, and the section between both.
struct Detached {
    lower: u32,
    upper: u32,
    section_mm2: f64,
}

/// Separates from a cell what lies above a plane at the section nearest to a point; all other pieces stay with what they touch.
///
/// `None` if the plane cuts nothing off.
fn detach(partition: &mut Partition, cell: u32, plane: &CutPlane, near: &Point3<f64>) -> Option<Detached> {
    let cut = partition.cut(&[cell], plane);
    let mut nearest: Option<(f64, u32, u32)> = None;
    for &upper in &cut.above {
        for wall in partition.walls(upper) {
            let Some(lower) = wall.beyond.filter(|cell| cut.below.contains(cell)) else { continue };
            let far = wall.places.iter().map(|p| (p - near).norm()).fold(f64::INFINITY, f64::min);
            if nearest.is_none_or(|(least, ..)| far < least) {
                nearest = Some((far, upper, lower));
            }
        }
    }
    let (_, upper, lower) = nearest?;
    let mut rest: Vec<u32> = cut.above.into_iter().chain(cut.below).filter(|&c| c != upper && c != lower).collect();
    while let Some(at) =
        rest.iter().position(|&piece| [lower, upper].into_iter().any(|cell| partition.shared_area(cell, piece) > 0.0))
    {
        let piece = rest.remove(at);
        let to = if partition.shared_area(lower, piece) > 0.0 { lower } else { upper };
        partition.merge(to, piece);
    }
    rest.into_iter().for_each(|piece| partition.merge(lower, piece));
    Some(Detached { lower, upper, section_mm2: partition.shared_area(lower, upper) })
}

/// Whether a plane cuts no section between a part and another one.
fn spares_sections(walls: &[Wall], plane: &CutPlane) -> bool {
    let mut sides: BTreeMap<u32, [bool; 2]> = BTreeMap::new();
    for wall in walls {
        let Some(beyond) = wall.beyond else { continue };
        let seen = sides.entry(beyond).or_default();
        for side in wall.places.map(|p| plane.side(&p)) {
            seen[0] |= side > 0;
            seen[1] |= side < 0;
        }
    }
    sides.values().all(|side| *side != [true; 2])
}

impl State {
    /// Cuts the whole solid along the perturbed planes of a sequence.
    pub(super) fn follow(
        &mut self,
        sequence: &BuildSequence,
        report: &dyn Fn(usize, usize) -> Result<(), RoboFdmError>,
    ) -> Result<(), RoboFdmError> {
        let mut random = Random::new();
        // Which node holds each part of the sequence.
        let mut node_of: Vec<(u32, usize)> = sequence.parts.first().map(|root| (root.part, 0)).into_iter().collect();
        for (done, part) in sequence.parts.iter().enumerate().skip(1) {
            report(done, sequence.parts.len())?;
            let holder = |p: u32| node_of.iter().find(|(known, _)| *known == p).map_or(0, |&(_, node)| node);
            let parent = part.parent.map_or(0, holder);
            let made = part.base.is_some_and(|base| self.perturbed(parent, &base, &part.direction, &mut random));
            node_of.push((part.part, if made { self.nodes.len() - 1 } else { parent }));
        }
        Ok(())
    }

    /// Cuts a part off a node by the best plane near the given one. Whether there is one that keeps the constraints.
    fn perturbed(&mut self, node: usize, base: &Point3<f64>, normal: &Vector3<f64>, random: &mut Random) -> bool {
        let walls = Arc::clone(&self.nodes[node].walls);
        let cell = self.nodes[node].cell;
        let alone = self.partition.only(&[cell]);
        let mut largest = f64::INFINITY;
        let mut best: Option<(f64, CutPlane, Point3<f64>)> = None;
        for trial in 0..=self.options.perturbations {
            let (turn, by) = if trial == 0 {
                (UnitQuaternion::identity(), 0.0)
            } else {
                (random.turn(self.options.max_turn), random.signed())
            };
            let place = base + normal * (by * self.options.max_offset * self.diagonal);
            let Ok(plane) = CutPlane::through(&place, &(turn * normal)) else { continue };
            let looks_up = self.options.head.is_some() || plane.normal().dot(&self.up) > 0.0;
            let allowed = looks_up && spares_sections(&walls, &plane);
            // The first one also says how large the section is.
            if !allowed && trial > 0 {
                continue;
            }
            let mut next = alone.clone();
            let Some(detached) = detach(&mut next, cell, &plane, &place) else { continue };
            if trial == 0 {
                largest = detached.section_mm2 * self.options.max_section;
            }
            if !allowed || detached.section_mm2 > largest {
                continue;
            }
            let [lower, upper] = [detached.lower, detached.upper].map(|cell| next.walls(cell));
            // What is taken off comes last.
            let mut earlier: Vec<u32> =
                self.nodes.iter().map(|node| node.cell).filter(|&other| other != cell).collect();
            earlier.push(detached.lower);
            let above =
                RiskModel { earlier, direction: plane.normal(), floor: f64::NEG_INFINITY, ..self.judge(node, &lower) };
            let risky = self.judge(node, &lower).risky(&lower) + above.risky(&upper);
            let better = best.as_ref().is_none_or(|(least, ..)| risky < *least);
            let others = (0..self.nodes.len()).filter(|&other| other != node).map(|other| &self.nodes[other].walls[..]);
            if better && self.head_passes(&plane.normal(), &upper, others.chain([&lower[..]])) {
                best = Some((risky, plane, place));
            }
        }
        let Some((_, plane, place)) = best else { return false };
        let whole = self.clone();
        let made = detach(Arc::make_mut(&mut self.partition), cell, &plane, &place);
        let Some(Detached { lower, upper, .. }) = made else { unreachable!("the same cut was made on the part alone") };
        (self.nodes[node].cell, self.nodes[node].walls) = (lower, Arc::default());
        self.nodes.push(Node::new(upper, plane.normal(), Some(plane)));
        self.refresh(&[cell]);
        if !self.holds_like(&whole) {
            *self = whole;
            return false;
        }
        true
    }
}
