//! How parts are tuned.

use super::error::RoboFdmError;
use super::head::Head;
use super::strength::SeamStrength;

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

/// A cut is not worth its seam unless it saves this share of the first risky area. It is halved with the distance of planes: otherwise small
/// areas that are left here and there add up to some percent; cuts that save less from the start make slivers.
const MIN_GAIN: f64 = 5e-4;

/// What a cut must save, as a share of the first risky area.
pub(super) fn min_gain(halvings: u32) -> f64 {
    MIN_GAIN / f64::from(2u32.pow(halvings.min(31)))
}

/// Says what is done, and whether to go on.
pub(super) type Report<'a> = dyn Fn(&'static str, usize, usize) -> Result<(), RoboFdmError> + Sync + 'a;
