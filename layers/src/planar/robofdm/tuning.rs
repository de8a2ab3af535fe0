//! Phase III: a solid is cut along the planes of a sequence, and its parts are tuned until little of them is risky.
//!
//! Dissertation, section 2.4.3. Each plane is tried at random places near its own (*plane perturbation*); parts whose union is no worse are
//! one (*region merging*); the riskiest parts are cut again, by the best of many planes (*fine decomposition*, Eq. 2.2).
//! Constraint I: no two base sections intersect. Constraint II: all base planes look up; with [`TuningOptions::head`] instead: the head meets nothing that stands. Planes that break one are not used.
//!
//! Departures. A plane cuts only the section that it was made for, and not what it meets elsewhere. A section towards a later part is a
//! surface while its own part is printed, so it is risky if it looks down. A cut is tried on the solid before it is taken, so that pieces
//! that would float are seen.

use super::audit::AuditedPart;
use super::error::RoboFdmError;
use super::head::Head;
use super::reasons::{Left, left};
use super::sequence::BuildSequence;
use super::state::{Promises, State};
use super::strength::{Hold, SeamStrength};
use crate::Progress;
use crate::planar::{CutPlane, Solid};
use nalgebra::Vector3;
use std::ops::ControlFlow;

/// How parts are tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuningOptions {
    /// As in [`super::SequenceOptions::max_angle`].
    pub max_angle: f64,
    /// As in [`super::SequenceOptions::platform`], in mm.
    pub platform: f64,
    /// Places that are tried for each plane of the sequence, and for each cut of a fine decomposition that misses its goal without. Default 16.
    pub perturbations: u32,
    /// How far a plane is moved at most, as a share of the box diagonal. Default 0.025, the paper's.
    pub max_offset: f64,
    /// How far it is turned at most, in radians. Default 5 degrees, the paper's.
    pub max_turn: f64,
    /// A section may become so many times as large. Default 1.2, the paper's.
    pub max_section: f64,
    /// Of how many parts, the riskiest first, a cut is sought each time. Default 6, the paper's.
    pub candidates: usize,
    /// Normals that are tried, over the upper half of the sphere. Default 100, the paper's.
    pub normals: usize,
    /// Distance of the planes that are tried, in mm. Default 5, the paper's.
    pub spacing: f64,
    /// How often that distance is halved, and with it the cost of seams, and normals are doubled, when no plane is worth a cut any more.
    /// Default 3; the paper has 0.
    pub halvings: u32,
    /// Whether no two base sections may intersect: constraint I to the letter. Default `false`: the section of a cut may end on the
    /// base plane of a part that is printed later. All that stands when that part is printed lies below its plane, so nothing is in
    /// the way (the collision of the paper's Fig. 2.6 needs a part that is printed earlier).
    pub keep_sections_apart: bool,
    /// A cut must save so much risky area for each area of its seam. Default 0: Eq. 2.2 as it stands.
    pub seam_cost: f64,
    /// Pieces smaller than this share of the solid stay with the rest. Default 1e-4.
    pub min_piece: f64,
    /// Most parts. Default 40.
    pub max_parts: usize,
    /// Share of the risky area of the whole solid, printed along the root's direction, at which the work is done. Default 0.01.
    pub goal: f64,
    /// The head of the printer, which must meet nothing that stands when a part is printed; it takes the place of constraint II. Default
    /// `None`: constraint II, all base planes look up.
    pub head: Option<Head>,
    /// What seams must hold: a cut that makes one too weak is not made, unless another was weaker before. Default `None`: seams of any size,
    /// as in the paper.
    pub strength: Option<SeamStrength>,
}

impl Default for TuningOptions {
    fn default() -> Self {
        Self {
            max_angle: std::f64::consts::FRAC_PI_4,
            platform: 0.2,
            perturbations: 16,
            max_offset: 0.025,
            max_turn: 5f64.to_radians(),
            max_section: 1.2,
            candidates: 6,
            normals: 100,
            spacing: 5.0,
            halvings: 3,
            keep_sections_apart: false,
            seam_cost: 0.0,
            min_piece: 1e-4,
            max_parts: 40,
            goal: 0.01,
            head: None,
            strength: None,
        }
    }
}

/// A part as it is printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedPart {
    /// Its closed mesh.
    pub solid: Solid,
    /// The direction in which it is printed, of length 1.
    pub direction: Vector3<f64>,
    /// The plane on which it is printed; none for one that stands on the platform.
    pub base: Option<CutPlane>,
    /// Area of its surface that is risky, in mm2.
    pub risky_mm2: f64,
    /// Area that it shares with earlier parts, in mm2.
    pub seam_mm2: f64,
    /// The earlier parts that it touches, by rising number.
    pub on: Vec<usize>,
    /// What it shares with each of them.
    pub seams: Vec<Seam>,
}

/// Where a part is joined to an earlier one: the weak place of a print (section 2.5 of the dissertation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// The earlier part.
    pub on: usize,
    /// Its area, in mm2.
    pub area_mm2: f64,
    /// The mean of its normals from the earlier part to the later one, of length 1; zero where they cancel.
    pub normal: Vector3<f64>,
}

impl Seam {
    /// Angle between a load and the normal of the seam, in radians, at most a right one: at 0 the load pulls the parts straight off each
    /// other, at a right angle it shears them. `None` for a load or a normal without length.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Vector3;
    /// use curvlay_layers::planar::robofdm::Seam;
    /// let seam = Seam { on: 0, area_mm2: 9.0, normal: Vector3::x() };
    /// assert!((seam.load_angle(&Vector3::new(-2.0, 2.0, 0.0)).unwrap().to_degrees() - 45.0).abs() < 1e-12);
    /// assert_eq!(seam.load_angle(&Vector3::zeros()), None);
    /// ```
    pub fn load_angle(&self, load: &Vector3<f64>) -> Option<f64> {
        let is_one = |v: &Vector3<f64>| v.norm() > 0.0 && v.norm().is_finite();
        let angle = self.normal.cross(load).norm().atan2(self.normal.dot(load).abs());
        (is_one(load) && is_one(&self.normal)).then_some(angle)
    }
}

impl PrintedPart {
    /// As an audit takes it.
    pub fn audited(&self) -> AuditedPart<'_> {
        AuditedPart { solid: &self.solid, direction: self.direction, on_platform: self.base.is_none() }
    }
}

/// A solid in parts, in the order in which they are printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// The parts.
    pub parts: Vec<PrintedPart>,
    /// Risky area of the whole solid, printed in the direction of the first part, in mm2.
    pub risky_before_mm2: f64,
    /// Risky area after the planes of the sequence were perturbed, after parts were merged, and after the fine
    /// decomposition, in mm2.
    pub risky_after_phases_mm2: [f64; 3],
    /// How each part is held by what is below it; empty without [`TuningOptions::strength`].
    pub holds: Vec<Hold>,
    /// Why risky area is left, by parts in their order; empty where the goal is met.
    pub left: Vec<Left>,
}

impl Decomposition {
    /// The parts of a state that is done.
    pub(super) fn of(state: &State, before: f64, after: [f64; 3], tell: &Tell) -> Result<Self, RoboFdmError> {
        Ok(Decomposition {
            parts: state.printed()?,
            risky_before_mm2: before,
            risky_after_phases_mm2: after,
            holds: state.holds(),
            left: left(state, before, tell)?,
        })
    }

    /// Risky area of all parts, in mm2.
    pub fn risky_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.risky_mm2).sum()
    }

    /// Area of all seams, in mm2.
    pub fn seam_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.seam_mm2).sum()
    }
}

/// A cut is not worth its seam unless it saves this share of the first risky area. It is halved with the distance of planes: otherwise small
/// areas that are left here and there add up to some percent; cuts that save less from the start make slivers.
const LEAST_GAIN: f64 = 5e-4;

/// What a cut must save, as a share of the first risky area.
pub(super) fn least_gain(halvings: u32) -> f64 {
    LEAST_GAIN / f64::from(2u32.pow(halvings.min(31)))
}

/// Cuts a solid along a sequence of planes and tunes the parts.
///
/// # Returns
/// The parts; the first one stands on the platform. Risky area may be left: see [`Decomposition::risky_mm2`].
///
/// # Errors
/// [`RoboFdmError::Option`] for an option out of range, [`RoboFdmError::Part`] for a part that does not bound a solid,
/// [`RoboFdmError::Cancelled`] if `progress` says so.
///
/// # Cost
/// A cut of the mesh for each perturbation and each trial, and for each fine cut `normals` operations for each triangle of the riskiest parts.
/// One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::Solid;
/// use curvlay_layers::planar::robofdm::{SegmentOptions, SequenceOptions, TuningOptions, plan_sequence, segment, tune};
/// use std::ops::ControlFlow;
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let segmentation = segment(&points, &faces, &SegmentOptions::default())?;
/// let sequence = plan_sequence(&points, &faces, &segmentation, &SequenceOptions::default())?;
/// let solid = Solid::new(&points, &faces)?;
/// let parts = tune(&solid, &sequence, &TuningOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((parts.parts.len(), parts.risky_mm2()), (1, 0.0)); // a rod needs no support
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tune(
    solid: &Solid,
    sequence: &BuildSequence,
    options: &TuningOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Decomposition, RoboFdmError> {
    options.check()?;
    let Some(root) = sequence.parts.first() else { return Err(RoboFdmError::Empty) };
    let whole = State::whole(solid, root.direction, options);
    let mut state = whole.clone();
    let before = state.risky();
    let tell =
        |stage, done: usize, total: usize| match progress(Progress { stage, done: done as u64, total: total as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RoboFdmError::Cancelled),
        };
    state.follow(sequence, &|done, total| tell("planes", done, total))?;
    let mut after = [state.risky(); 3];
    tell("merging", 0, 1)?;
    state.merge();
    // Segments of a solid that needs no support may well need some, and where a head is in the way not all can be merged.
    if state.risky() > before || state.nodes.len() > options.max_parts {
        state = whole;
    }
    after[1] = state.risky();
    state = polished(finely_decomposed(&state, before, &tell)?, before, &tell)?;
    after[2] = state.risky();
    Decomposition::of(&state, before, after, &tell)
}

/// Says what is done, and whether to go on.
pub(super) type Tell<'a> = dyn Fn(&'static str, usize, usize) -> Result<(), RoboFdmError> + Sync + 'a;

/// From which halving of the distance of planes on each plane is refined, one way after the other until the goal is reached.
const REFINED_FROM: [u32; 3] = [u32::MAX, 1, 0];

/// Fine decomposition of a state, merged again; where it misses the goal also with planes refined, and the best result taken. A refined
/// plane saves more at once, but the best cut now is not always the best one in the end.
pub(super) fn finely_decomposed(state: &State, before: f64, tell: &Tell) -> Result<State, RoboFdmError> {
    let mut best: Option<State> = None;
    for refined_from in REFINED_FROM {
        let mut next = decomposed(state, before, refined_from, tell)?;
        next.merge();
        let risky = next.risky();
        if best.as_ref().is_none_or(|best| risky < best.risky()) {
            best = Some(next);
        }
        if risky <= state.options.goal * before {
            break;
        }
    }
    Ok(best.unwrap_or_else(|| state.clone()))
}

/// Cuts a state on as long as that pays at the finest distance of planes: merging makes parts through which planes were not tried yet, and a beam
/// may end before all of its last state were.
pub(super) fn polished(mut state: State, before: f64, tell: &Tell) -> Result<State, RoboFdmError> {
    let (mut known, least) = (Promises::new(), least_gain(state.options.halvings) * before);
    while state.risky() > state.options.goal * before && state.nodes.len() < state.options.max_parts {
        tell("cuts", state.nodes.len(), state.options.max_parts)?;
        if !state.cut_finely(&mut known, least, true) {
            break;
        }
    }
    Ok(state)
}

/// The best cut of one of the riskiest parts, again and again.
fn decomposed(state: &State, before: f64, refined_from: u32, tell: &Tell) -> Result<State, RoboFdmError> {
    let (mut state, mut known, mut halvings) = (state.clone(), Promises::new(), 0);
    while state.risky() > state.options.goal * before && state.nodes.len() < state.options.max_parts {
        tell("cuts", state.nodes.len(), state.options.max_parts)?;
        if state.cut_finely(&mut known, least_gain(halvings) * before, halvings >= refined_from) {
            continue;
        }
        if halvings == state.options.halvings {
            break;
        }
        // What is left takes finer planes, and a seam that pays less.
        halvings += 1;
        state.options = state.options.finer();
        known.clear();
    }
    Ok(state)
}

impl TuningOptions {
    /// The next options when no plane is worth a cut any more.
    pub(super) fn finer(&self) -> Self {
        TuningOptions {
            spacing: self.spacing / 2.0,
            seam_cost: self.seam_cost / 2.0,
            normals: 2 * self.normals,
            ..*self
        }
    }

    pub(super) fn check(&self) -> Result<(), RoboFdmError> {
        self.head.map_or(Ok(()), |head| head.check())?;
        let named = [
            ("max_angle", self.max_angle, 1e-6, std::f64::consts::FRAC_PI_2 - 1e-6),
            ("platform", self.platform, 0.0, 1e9),
            ("max_offset", self.max_offset, 0.0, 1.0),
            ("max_turn", self.max_turn, 0.0, std::f64::consts::FRAC_PI_2),
            ("max_section", self.max_section, 1.0, 1e9),
            ("candidates", self.candidates as f64, 1.0, 1e6),
            ("normals", self.normals as f64, 1.0, 1e6),
            ("spacing", self.spacing, 1e-3, 1e9),
            ("seam_cost", self.seam_cost, 0.0, 1e9),
            ("min_piece", self.min_piece, 0.0, 1.0),
            ("max_parts", self.max_parts as f64, 1.0, 1e6),
            ("goal", self.goal, 0.0, 1.0),
        ];
        let strength = self.strength.iter().flat_map(SeamStrength::ranges);
        match named.into_iter().chain(strength).find(|(_, value, low, high)| !(low..=high).contains(&value)) {
            Some((name, value, ..)) => Err(RoboFdmError::Option { name, value }),
            None => Ok(()),
        }
    }
}
