//! Which branch and which whole turns the axes take along a bead and the travels before it: dynamic programming over the few that each node has.
//!
//! A state goes on to the same branch at the next node, continuously. Any state of a node may change to any other one by a rewind. Through the neighbourhood of a pole all
//! states lead to all: the first axis turns on the way, slowly, or in a rewind where that would take too long. What is minimised is the number of rewinds
//! within beads, then between them, then the time of turning.

use super::nodes::Node;
use super::speed::turning;
use super::task::Task;
use crate::angle::nearest_image;
use crate::machine::geometry::{Images, Posture, Rotary};
use crate::machine::inverse::Pair;
use crate::machine::reach::Unreachable;
use std::f64::consts::{FRAC_PI_4, TAU};
use std::ops::Range;

/// What lies between a node and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    /// Time at the feed of the move.
    pub seconds: f64,
    pub is_printing: bool,
}

/// How the axes stand at a node, and how they go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    /// Where they arrive; they leave from another posture after a rewind.
    pub arrive: Posture,
    pub leave: Posture,
    /// The branch until the next node; `None` through a pole.
    pub branch: Option<u8>,
    /// The nozzle lifts off between both.
    pub is_rewind: bool,
}

/// A node that nothing leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DeadEnd {
    pub node: usize,
    pub reason: Unreachable,
}

/// Costs of a rewind within a bead, at an end of a bead, and between beads, in seconds of turning.
const CUT: f64 = 1e9;
const EDGE: f64 = 2e5;
const FREE: f64 = 1e5;

/// Cost of a way that the linear axes do not reach: it is taken, and reported, where there is no other one.
const OUT_OF_REACH: f64 = 1e12;

/// Whole turns on either side of the first reading that are looked at, beside those to which a bead winds on: an axis of more turns may be wound back once more than it must.
const TURNS: u64 = 4;

/// A reading goes on continuously from another one by less than this, radians; nodes stand closer, and images are a whole turn apart.
const CONTINUOUS: f64 = 2.0;

/// Share of the time of turning that counts where it costs no time.
const EFFORT: f64 = 1e-3;

#[derive(Clone, Copy, Debug)]
struct State {
    rotary: [f64; 2],
    branch: Option<u8>,
    /// Cost of arriving in this state, and of leaving in it.
    arrive: f64,
    leave: f64,
    /// The state of the column before from which it is reached, and that of its own column in which the axes have arrived when they leave in this one.
    from: usize,
    arrived: usize,
    /// There is a rewind within the pole before.
    is_cut: bool,
}

#[derive(Clone, Debug)]
struct Column {
    node: usize,
    states: Range<usize>,
}

struct Search<'a> {
    task: &'a Task<'a>,
    nodes: &'a [Node],
    intervals: &'a [Interval],
    near: [f64; 2],
    /// The axes are at the first node: a bead has ended there.
    is_there: bool,
    states: Vec<State>,
    columns: Vec<Column>,
}

/// Chooses for all nodes.
///
/// # Arguments
/// * `near`: where the rotary axes are. With `is_there` they are at the first node, else they come from elsewhere.
pub(super) fn choose(
    task: &Task<'_>,
    nodes: &[Node],
    intervals: &[Interval],
    near: [f64; 2],
    is_there: bool,
) -> Result<Vec<Choice>, DeadEnd> {
    let mut search = Search { task, nodes, intervals, near, is_there, states: vec![], columns: vec![] };
    search.first()?;
    let last = nodes.len() - 1;
    for (number, node) in nodes.iter().enumerate().skip(1) {
        if !node.is_inside || number == last {
            search.column(number)?;
        }
    }
    Ok(search.choices())
}

/// The difference that a motion of an axis has: an endless one goes the short way.
fn difference(axis: &Rotary, from: f64, to: f64) -> f64 {
    if axis.is_endless() { nearest_image(to, from) - from } else { to - from }
}

impl Search<'_> {
    fn ways(&self, from: &[f64; 2], to: &[f64; 2]) -> [f64; 2] {
        [0, 1].map(|k: usize| difference(&self.task.machine.rotary[k], from[k], to[k]))
    }

    fn seconds(&self, from: &[f64; 2], to: &[f64; 2]) -> f64 {
        turning(self.task.machine, self.ways(from, to))
    }

    fn push(&mut self, rotary: [f64; 2], branch: Option<u8>) {
        let arrived = self.states.len();
        self.states.push(State {
            rotary,
            branch,
            arrive: f64::INFINITY,
            leave: f64::INFINITY,
            from: 0,
            arrived,
            is_cut: false,
        });
    }

    /// All states of a node outside of poles: the turns next to where the axes were at first, and those with which states of the column before go on.
    fn push_all(&mut self, node: usize, before: Range<usize>) {
        let (machine, pose) = (self.task.machine, self.nodes[node].pose);
        let Ok(pairs) = machine.pairs(&pose.tip, &pose.direction, self.near) else { return };
        let start = self.states.len();
        for pair in pairs.into_iter().flatten() {
            if !machine.has_linear(&machine.place(&pose.tip, &pair.rotary)) {
                continue;
            }
            let near = self.near;
            self.push_turns_of(&pair, near, TURNS, start);
            for from in before.clone() {
                self.push_turns_of(&pair, self.states[from].rotary, 0, start);
            }
        }
    }

    /// Images of a pair next to `near`, but for those that are there already, from `start` on.
    fn push_turns_of(&mut self, pair: &Pair, near: [f64; 2], turns: u64, start: usize) {
        let axes = &self.task.machine.rotary;
        let images = [0, 1].map(|k: usize| axes[k].images(pair.rotary[k], near[k]));
        let [Some(first), Some(second)] = images else { return };
        let window = |images: &Images, near: f64| {
            // Saturates at 0.
            let middle = (((near - images.first) / TAU).round() as u64).min(images.count - 1);
            middle.saturating_sub(turns)..images.count.min(middle + turns + 1)
        };
        for turn in window(&first, near[0]) {
            for tilt in window(&second, near[1]) {
                let rotary = [axes[0].image(&first, turn), axes[1].image(&second, tilt)];
                let is_there = |state: &State| {
                    let ways = self.ways(&state.rotary, &rotary);
                    state.branch == Some(pair.branch) && ways.iter().all(|way| way.abs() < 1.0)
                };
                if !self.states[start..].iter().any(is_there) {
                    self.push(rotary, Some(pair.branch));
                }
            }
        }
    }

    fn first(&mut self) -> Result<(), DeadEnd> {
        if self.nodes[0].is_inside {
            self.push_turns()
        } else {
            self.push_all(0, 0..0)
        }
        // Where the axes are there already, they arrive in one state, of which only the branch is not known; a rewind leads to the others.
        let cost = |state: &State| self.ways(&self.near, &state.rotary).iter().map(|way| way.abs()).sum::<f64>();
        let nearest = (0..self.states.len()).min_by(|&a, &b| cost(&self.states[a]).total_cmp(&cost(&self.states[b])));
        for k in 0..self.states.len() {
            let seconds = self.seconds(&self.near, &self.states[k].rotary);
            if !self.is_there {
                self.states[k].arrive = seconds;
            } else if nearest == Some(k) {
                (self.states[k].arrive, self.states[k].rotary) = (0.0, self.near);
            }
        }
        self.close(0, 0)
    }

    /// States within a pole: the turn where it is, and eighths of a turn, since not with each the linear axes reach the whole bead.
    fn push_turns(&mut self) {
        let [min, max] = self.task.machine.rotary[0].range;
        let pose = self.nodes[0].pose;
        let first = self.near[0].clamp(min, max);
        let there = self.task.at_pole(&pose, first, self.near[1]).rotary;
        self.push(if self.is_there { self.near } else { there }, None);
        for eighth in 0..8 {
            let turn = nearest_image(self.task.machine.rotary[0].zero + f64::from(eighth) * FRAC_PI_4, first);
            if turn >= min && turn <= max {
                let rotary = self.task.at_pole(&pose, turn, self.near[1]).rotary;
                self.push(rotary, None);
            }
        }
    }

    /// The states of the next node, and how they are reached.
    fn column(&mut self, node: usize) -> Result<(), DeadEnd> {
        let before = self.columns[self.columns.len() - 1].clone();
        let start = self.states.len();
        if self.nodes[node].is_inside {
            self.stay(&before, node);
        } else {
            self.push_all(node, before.states.clone());
            let is_direct = node == before.node + 1 && !self.nodes[before.node].is_inside;
            for to in start..self.states.len() {
                for from in before.states.clone() {
                    let (cost, is_cut) = if is_direct {
                        (self.directly(from, to, before.node), false)
                    } else {
                        self.through_pole(from, to, before.node..node)
                    };
                    let cost = self.states[from].leave + cost;
                    if cost < self.states[to].arrive {
                        let state = &mut self.states[to];
                        (state.arrive, state.from, state.is_cut) = (cost, from, is_cut);
                    }
                }
            }
        }
        self.close(node, start)
    }

    /// The last node is inside of a pole: the first axis stays, if the linear axes reach all nodes then.
    fn stay(&mut self, before: &Column, node: usize) {
        let mut least = f64::INFINITY;
        for from in before.states.clone() {
            let state = self.states[from];
            if state.leave >= least {
                continue;
            }
            let reaches = |node: &Node| {
                let there = self.task.at_pole(&node.pose, state.rotary[0], state.rotary[1]);
                self.task.machine.has_linear(&there.linear)
            };
            let is_reached = self.nodes[before.node + 1..=node].iter().all(reaches);
            let there = self.task.at_pole(&self.nodes[node].pose, state.rotary[0], state.rotary[1]);
            let arrive = state.leave + if is_reached { 0.0 } else { OUT_OF_REACH };
            least = least.min(arrive);
            self.push(there.rotary, None);
            if let Some(last) = self.states.last_mut() {
                (last.arrive, last.from) = (arrive, from);
            }
        }
    }

    fn directly(&self, from: usize, to: usize, interval: usize) -> f64 {
        let (a, b) = (&self.states[from], &self.states[to]);
        let ways = self.ways(&a.rotary, &b.rotary);
        if a.branch != b.branch || ways.iter().any(|way| way.abs() > CONTINUOUS) {
            return f64::INFINITY;
        }
        let turning = turning(self.task.machine, ways);
        (turning - self.intervals[interval].seconds).max(0.0) + EFFORT * turning
    }

    /// The cost, and whether there is a rewind.
    fn through_pole(&self, from: usize, to: usize, run: Range<usize>) -> (f64, bool) {
        let turning = self.seconds(&self.states[from].rotary, &self.states[to].rotary);
        let run = &self.intervals[run];
        let has_travel = run.iter().any(|interval| !interval.is_printing);
        let seconds: f64 = run.iter().map(|interval| interval.seconds).sum();
        let slow = (turning - seconds).max(0.0) + EFFORT * turning;
        let options = &self.task.options;
        let is_fast = turning <= (options.max_slowdown * seconds).max(options.max_pole_wait_s);
        if has_travel || is_fast { (slow, false) } else { (CUT + turning, true) }
    }

    /// Ends a column: what a rewind makes cheaper.
    fn close(&mut self, node: usize, start: usize) -> Result<(), DeadEnd> {
        let states = start..self.states.len();
        let best = states.clone().min_by(|&a, &b| self.states[a].arrive.total_cmp(&self.states[b].arrive));
        let is_reached = best.is_some_and(|best| self.states[best].arrive.is_finite());
        if !is_reached {
            return Err(DeadEnd { node, reason: self.reason(node) });
        }
        let is_printing = |k: usize| self.intervals.get(k).is_some_and(|interval| interval.is_printing);
        let has_bead = if node == 0 { self.is_there } else { is_printing(node - 1) };
        let beads = [has_bead, is_printing(node)];
        let rewind = match beads {
            [true, true] => CUT,
            [false, false] => FREE,
            _ => EDGE,
        };
        for to in states.clone() {
            let mut least = (self.states[to].arrive, to);
            for from in states.clone().filter(|&from| from != to) {
                let [a, b] = [from, to].map(|k| &self.states[k]);
                let cost = a.arrive + rewind + self.seconds(&a.rotary, &b.rotary);
                if cost < least.0 {
                    least = (cost, from);
                }
            }
            (self.states[to].leave, self.states[to].arrived) = least;
        }
        self.columns.push(Column { node, states });
        Ok(())
    }

    fn reason(&self, node: usize) -> Unreachable {
        let why = |node: usize, share: f64| {
            let pose = match node {
                0 => self.nodes[0].pose,
                _ => self.nodes[node - 1].pose.towards(&self.nodes[node].pose, share),
            };
            let direction = nalgebra::UnitVector3::new_normalize(pose.direction);
            self.task.machine.unreachable(&pose.tip.into(), &direction)
        };
        let all = (1..=16).rev().map(|k| f64::from(k) / 16.0);
        all.filter_map(|share| why(node, share)).next().unwrap_or(Unreachable::Gap)
    }

    /// Follows the cheapest way back, then forward: endless axes wind up.
    fn choices(&self) -> Vec<Choice> {
        let count = self.columns.len();
        let mut ways = vec![(0, 0); count];
        let last = self.columns[count - 1].states.clone();
        let cheapest = last.min_by(|&a, &b| self.states[a].arrive.total_cmp(&self.states[b].arrive)).unwrap_or(0);
        let mut arrive = cheapest;
        let mut leave = cheapest;
        for k in (0..count).rev() {
            ways[k] = (arrive, leave);
            leave = self.states[arrive].from;
            arrive = self.states[leave].arrived;
        }
        let mut choices = Vec::with_capacity(self.nodes.len());
        let mut at = self.near;
        for (k, (column, (arrive, leave))) in self.columns.iter().zip(ways).enumerate() {
            let arrived = self.wound(at, &self.states[arrive].rotary);
            if k > 0 {
                self.fill(column.node, at, arrived, self.states[arrive].is_cut, &mut choices);
            }
            at = if arrive == leave { arrived } else { self.wound(arrived, &self.states[leave].rotary) };
            let is_direct = self.columns.get(k + 1).is_some_and(|next| {
                next.node == column.node + 1 && !self.nodes[next.node].is_inside && !self.nodes[column.node].is_inside
            });
            let branch = if is_direct { self.states[leave].branch } else { None };
            let tip = self.nodes[column.node].pose.tip;
            let is_rewind = arrive != leave;
            let [arrive, leave] = [arrived, at].map(|rotary| self.task.posture(&tip, rotary));
            choices.push(Choice { arrive, leave, branch, is_rewind });
        }
        choices
    }

    fn wound(&self, from: [f64; 2], to: &[f64; 2]) -> [f64; 2] {
        let ways = self.ways(&from, to);
        [0, 1].map(|k: usize| if self.task.machine.rotary[k].is_endless() { from[k] + ways[k] } else { to[k] })
    }

    /// The nodes within a pole, up to the one that ends it.
    fn fill(&self, end: usize, from: [f64; 2], to: [f64; 2], is_cut: bool, choices: &mut Vec<Choice>) {
        let start = choices.len() - 1;
        let run = &self.intervals[start..end];
        let has_travel = run.iter().any(|interval| !interval.is_printing);
        // The axis turns while the nozzle travels, if it does.
        let weight = |interval: &Interval| {
            let counts = !has_travel || !interval.is_printing;
            // Intervals without a length take their part, too.
            if counts { interval.seconds + 1e-9 } else { 0.0 }
        };
        let whole: f64 = run.iter().map(weight).sum();
        let mut done = 0.0;
        let mut is_behind = false;
        for node in start + 1..end {
            done += weight(&run[node - start - 1]);
            let share = done / whole;
            let pose = &self.nodes[node].pose;
            let at = |turn: f64| self.task.at_pole(pose, turn, to[1]);
            let turn = if is_cut && is_behind {
                to[0]
            } else if is_cut {
                from[0]
            } else {
                from[0] + (to[0] - from[0]) * share
            };
            let arrive = at(turn);
            // The rewind is in the middle, or at the last node inside.
            let is_here = is_cut && !is_behind && (share >= 0.5 || node + 1 == end);
            let leave = if is_here { at(to[0]) } else { arrive };
            is_behind |= is_here;
            choices.push(Choice { arrive, leave, branch: None, is_rewind: is_here });
        }
    }
}
