//! How stiff a part with tapes in it is, from its lay-up: in tension, as a beam in bending, and as an arch that is pressed flat.
//!
//! What is compared with the tests of Dai 2020, section 5.4: `E` there is [`LayUp::modulus_gpa`], `EI = P L^3 / (48 d)` is
//! [`LayUp::rigidity_nm2`] and [`three_point_rigidity_nm2`], and the slope of the curves of figure 5.8 is [`arch_stiffness_n_mm`].
//!
//! Theory: rule of mixtures (strains along the fibres are equal); layered beams (plane sections stay plane, so strain is linear in the
//! distance from the neutral axis); thin arches (bending alone). Fibre is counted as solid area at the height of its tape, and displaces
//! thermoplastic. Bonds are perfect: what slips or is not soaked makes a real part softer. All of this is textbook mechanics; the dissertation
//! measures and does not predict.

use std::f64::consts::FRAC_PI_2;

/// Tapes at a height of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapeInSection {
    /// Above the bottom, in millimetres.
    pub at_mm: f64,
    /// Area of solid fibre in the section, in square millimetres: without what fills the gaps between the filaments.
    pub fiber_mm2: f64,
}

/// The section of a bar, and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct LayUp {
    /// Across the bar, in millimetres.
    pub width_mm: f64,
    /// Through its layers, in millimetres.
    pub height_mm: f64,
    /// Modulus of the thermoplastic, in GPa.
    pub matrix_gpa: f64,
    /// Modulus of the fibre along itself, in GPa.
    pub fiber_gpa: f64,
    /// The tapes, in any order.
    pub tapes: Vec<TapeInSection>,
}

/// Why there is no stiffness.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StiffnessError {
    /// A number that must be above 0 and finite.
    #[error("`{what}` is {value}: it must be above 0 and finite")]
    Number {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A tape outside of its section, or with an invalid area.
    #[error(
        "tape {tape} is at {at_mm} mm of a section of {height_mm} mm, with {fiber_mm2} mm^2 of fibre: it does not fit in"
    )]
    Tape {
        /// The tape, from 0.
        tape: usize,
        /// Its height.
        at_mm: f64,
        /// Height of the section.
        height_mm: f64,
        /// Its fibre.
        fiber_mm2: f64,
    },
    /// The section is all fibre.
    #[error("the tapes have {fiber_mm2} mm^2 of fibre, the section {section_mm2} mm^2: no thermoplastic is left")]
    Full {
        /// Fibre.
        fiber_mm2: f64,
        /// The section.
        section_mm2: f64,
    },
    /// Pieces of an arch that do not follow each other up to its end.
    #[error(
        "piece {piece} of the arch ends at {angle} rad: pieces end one after the other, the last at {half_angle} rad"
    )]
    Piece {
        /// The piece, from 0.
        piece: usize,
        /// Where it ends.
        angle: f64,
        /// Half the arch.
        half_angle: f64,
    },
}

/// GPa mm^4 in N m^2.
const NM2: f64 = 1e-3;
/// N m^2 in N mm^2.
const MM2_PER_M2: f64 = 1e6;

fn positive(what: &'static str, value: f64) -> Result<f64, StiffnessError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(StiffnessError::Number { what, value }) }
}

impl LayUp {
    fn check(&self) -> Result<(), StiffnessError> {
        let LayUp { width_mm, height_mm, matrix_gpa, fiber_gpa, .. } = *self;
        for (what, value) in
            [("width_mm", width_mm), ("height_mm", height_mm), ("matrix_gpa", matrix_gpa), ("fiber_gpa", fiber_gpa)]
        {
            positive(what, value)?;
        }
        for (tape, &TapeInSection { at_mm, fiber_mm2 }) in self.tapes.iter().enumerate() {
            if !((0.0..=height_mm).contains(&at_mm) && (0.0..f64::INFINITY).contains(&fiber_mm2)) {
                return Err(StiffnessError::Tape { tape, at_mm, height_mm, fiber_mm2 });
            }
        }
        let (fiber_mm2, section_mm2) = (self.fiber_mm2(), width_mm * height_mm);
        if fiber_mm2 >= section_mm2 {
            return Err(StiffnessError::Full { fiber_mm2, section_mm2 });
        }
        Ok(())
    }

    fn fiber_mm2(&self) -> f64 {
        self.tapes.iter().map(|tape| tape.fiber_mm2).sum()
    }

    /// Share of the section that is fibre.
    ///
    /// # Errors
    /// [`StiffnessError`].
    pub fn fiber_fraction(&self) -> Result<f64, StiffnessError> {
        self.check()?;
        Ok(self.fiber_mm2() / (self.width_mm * self.height_mm))
    }

    /// Modulus along the bar in GPa, by the rule of mixtures: that of fibre and of thermoplastic by their shares.
    ///
    /// # Errors
    /// [`StiffnessError`].
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::fiber::stiffness::{LayUp, TapeInSection};
    /// // 2 % of fibre with 100 GPa in 1 GPa.
    /// let tapes = vec![TapeInSection { at_mm: 1.0, fiber_mm2: 0.4 }];
    /// let bar = LayUp { width_mm: 10.0, height_mm: 2.0, matrix_gpa: 1.0, fiber_gpa: 100.0, tapes };
    /// assert!((bar.modulus_gpa()? - (0.98 + 2.0)).abs() < 1e-12);
    /// # Ok::<(), curvlay_toolpath::fiber::stiffness::StiffnessError>(())
    /// ```
    pub fn modulus_gpa(&self) -> Result<f64, StiffnessError> {
        let share = self.fiber_fraction()?;
        Ok(self.matrix_gpa * (1.0 - share) + self.fiber_gpa * share)
    }

    /// Height of the neutral axis of bending above the bottom, in millimetres.
    ///
    /// # Errors
    /// [`StiffnessError`].
    pub fn neutral_mm(&self) -> Result<f64, StiffnessError> {
        let section = self.width_mm * self.height_mm;
        let more = self.fiber_gpa - self.matrix_gpa;
        let moment = self.matrix_gpa * section * self.height_mm / 2.0
            + self.tapes.iter().map(|tape| more * tape.fiber_mm2 * tape.at_mm).sum::<f64>();
        Ok(moment / (self.modulus_gpa()? * section))
    }

    /// Flexural rigidity `EI` about the neutral axis in N m^2, by the theory of layered beams. The tapes' own height is not counted.
    ///
    /// # Errors
    /// [`StiffnessError`].
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::fiber::stiffness::{LayUp, TapeInSection};
    /// // A tape in the middle does nothing but displace thermoplastic there.
    /// let bar = LayUp { width_mm: 10.0, height_mm: 5.0, matrix_gpa: 3.0, fiber_gpa: 230.0, tapes: Vec::new() };
    /// let tapes = vec![TapeInSection { at_mm: 2.5, fiber_mm2: 0.2 }];
    /// assert!((bar.rigidity_nm2()? - 3.0 * 10.0 * 125.0 / 12.0 * 1e-3).abs() < 1e-12);
    /// assert_eq!(LayUp { tapes, ..bar.clone() }.rigidity_nm2()?, bar.rigidity_nm2()?);
    /// # Ok::<(), curvlay_toolpath::fiber::stiffness::StiffnessError>(())
    /// ```
    pub fn rigidity_nm2(&self) -> Result<f64, StiffnessError> {
        let neutral = self.neutral_mm()?;
        let section = self.width_mm * self.height_mm;
        let about = |at_mm: f64| (at_mm - neutral).powi(2);
        let bar = section * (self.height_mm.powi(2) / 12.0 + about(self.height_mm / 2.0));
        let more = self.fiber_gpa - self.matrix_gpa;
        let tapes: f64 = self.tapes.iter().map(|tape| tape.fiber_mm2 * about(tape.at_mm)).sum();
        Ok((self.matrix_gpa * bar + more * tapes) * NM2)
    }
}

/// The rigidity that a test in three-point bending shows: `EI = P L^3 / (48 d)`, in N m^2.
///
/// # Arguments
/// * `force_n`: `P`, in the middle; `span_mm`: `L`, between the supports; `deflection_mm`: `d`, in the middle.
///
/// # Errors
/// [`StiffnessError::Number`].
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::stiffness::three_point_rigidity_nm2;
/// assert!((three_point_rigidity_nm2(48.0, 1000.0, 1.0)? - 1000.0).abs() < 1e-9);
/// # Ok::<(), curvlay_toolpath::fiber::stiffness::StiffnessError>(())
/// ```
pub fn three_point_rigidity_nm2(force_n: f64, span_mm: f64, deflection_mm: f64) -> Result<f64, StiffnessError> {
    let [force, span, deflection] =
        [positive("force_n", force_n)?, positive("span_mm", span_mm)?, positive("deflection_mm", deflection_mm)?];
    Ok(force * span.powi(3) / (48.0 * deflection) / MM2_PER_M2)
}

/// Force per sinking of the crown, in N/mm, of an arch whose ends slide on a table and whose crown is pressed down.
///
/// At the angle `a` from the crown the moment of half the force is `P/2 R (sin A - sin a)` for an arch of half angle `A`; by Castigliano the
/// crown sinks by the integral of `P/2 R^3 (sin A - sin a)^2 / EI` over `a` from 0 to `A`.
///
/// # Arguments
/// * `radius_mm`: of the neutral axis, thin beside it; `half_angle`: `A`, in radians, below pi/2.
/// * `pieces`: from the crown outwards, each with the angle at which it ends and its rigidity in N m^2; the last ends at `half_angle`.
///
/// # Errors
/// [`StiffnessError`].
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::stiffness::arch_stiffness_n_mm;
/// // A flat arch is a straight beam: 48 EI / L^3.
/// let (radius, half) = (1e4_f64, 1e-2_f64);
/// let beam = 48.0 * 0.5e6 / (2.0 * radius * half.sin()).powi(3);
/// assert!((arch_stiffness_n_mm(radius, half, &[(half, 0.5)])? / beam - 1.0).abs() < 1e-4);
/// # Ok::<(), curvlay_toolpath::fiber::stiffness::StiffnessError>(())
/// ```
pub fn arch_stiffness_n_mm(radius_mm: f64, half_angle: f64, pieces: &[(f64, f64)]) -> Result<f64, StiffnessError> {
    positive("radius_mm", radius_mm)?;
    positive("half_angle", half_angle.min(FRAC_PI_2 - half_angle))?;
    let mut from = 0.0;
    let mut sum = 0.0;
    for (piece, &(to, rigidity)) in pieces.iter().enumerate() {
        positive("rigidity_nm2", rigidity)?;
        if !(to > from && to <= half_angle) {
            return Err(StiffnessError::Piece { piece, angle: to, half_angle });
        }
        sum += (lever(half_angle, to) - lever(half_angle, from)) / (rigidity * MM2_PER_M2);
        from = to;
    }
    if from < half_angle {
        return Err(StiffnessError::Piece { piece: pieces.len(), angle: from, half_angle });
    }
    Ok(2.0 / (radius_mm.powi(3) * sum))
}

/// The integral of `(sin A - sin a)^2` up to an angle.
fn lever(half_angle: f64, to: f64) -> f64 {
    let s = half_angle.sin();
    s * s * to + 2.0 * s * (to.cos() - 1.0) + to / 2.0 - (2.0 * to).sin() / 4.0
}
