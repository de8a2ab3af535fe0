//! What a tape head does: the moves of tapes in a machine file, between those of the layers.
//!
//! Dai 2020, section 5.3.1 and figure 5.2: the head of the tape is put in place, heat and pressure travel along the tape, and a chopper cuts
//! it at the end of the path. The roller stands along the normal of the surface and presses against it.
//!
//! The blade stands before the roller, so the tape is cut while that much of it is still to be laid: `blade` is the length of the shortest tape.
//!
//! Between tapes, and to and from the nozzle's work, the head goes over all that is built: straight up, across at a height that is clear, and down
//! again. Tapes are few, so a longer way costs little.
//!
//! ```text
//! M2730 P1 tool     M2734 heat     for each tape: over its start, M2731 feed, down, M2732 press, lay, M2735 cut, lay the rest,
//!                                  M2732 S0, off it and up     M2733 S0     M2730 P0 back to the nozzle
//! ```

use super::tape::Tape;
use crate::gcode::{FiberCommand, Mark, Move, Tool};
use nalgebra::{Point3, UnitVector3};

/// A tape head and how it works.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TapeHead {
    /// Tape between the blade and the roller's contact line, in millimetres, above 0: 20.
    pub blade: f64,
    /// Force of the roller in newtons, 0.1 to 1e4: 20.
    pub force_n: f64,
    /// Its temperature in degrees Celsius, 0 (cold) to 2000: 210, at which the PLA of the dissertation is printed.
    pub celsius: f64,
    /// Speed along the tape in mm/s: 10.
    pub lay_feed: f64,
    /// Speed of the ways between tapes in mm/s: 80.
    pub travel_feed: f64,
    /// How far the roller backs off along the normal at both ends of a tape, and how high it goes over all that is built on its way, in
    /// millimetres: 10.
    pub hop: f64,
}

impl Default for TapeHead {
    fn default() -> Self {
        TapeHead { blade: 20.0, force_n: 20.0, celsius: 210.0, lay_feed: 10.0, travel_feed: 80.0, hop: 10.0 }
    }
}

/// The tapes on a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerTapes {
    /// The layer below them, from 0.
    pub layer: u32,
    /// What lays them: the roller, or the one for conductors.
    pub tool: Tool,
    /// How far the top of the layer is above the centre lines, along the normal, in millimetres: half a layer where they run through its
    /// middle, and what the layer is [raised](super::sandwich::SandwichLayer::raised).
    pub lift: f64,
    /// In the order in which they are laid.
    pub tapes: Vec<Tape>,
}

/// Why tapes cannot be laid. Tapes and layers are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TapeHeadError {
    /// An option is out of its range.
    #[error("`{option}` is {value}: it must be {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The nozzle lays no tape.
    #[error("the tapes of layer {layer} are for the nozzle: take the roller or the conductor")]
    Tool {
        /// The layer.
        layer: u32,
    },
    /// Lists out of order, or an invalid lift.
    #[error("tapes of layer {layer} come after those of a later one, or their lift is not finite")]
    Layer {
        /// The layer.
        layer: u32,
    },
    /// A tape without two points with a normal each, or with one that is not finite.
    #[error("tape {tape} of layer {layer} has no two finite points with a unit normal each, or no width and thickness")]
    Tape {
        /// The layer.
        layer: u32,
        /// The tape.
        tape: usize,
    },
    /// A tape that ends before the blade.
    #[error(
        "tape {tape} of layer {layer} is {length} mm long, but {blade} mm of tape are behind the blade when it is cut"
    )]
    Short {
        /// The layer.
        layer: u32,
        /// The tape.
        tape: usize,
        /// Its length.
        length: f64,
        /// The shortest that the head lays.
        blade: f64,
    },
}

impl TapeHead {
    fn check(&self) -> Result<(), TapeHeadError> {
        let ranges = [
            ("blade", self.blade, [1e-3, 1e6], "from 0.001 to 1e6 mm"),
            ("force_n", self.force_n, [0.1, 1e4], "from 0.1 to 1e4 N"),
            ("celsius", self.celsius, [0.0, 2000.0], "from 0 to 2000 degrees Celsius"),
            ("lay_feed", self.lay_feed, [1e-3, 1e5], "from 0.001 to 1e5 mm/s"),
            ("travel_feed", self.travel_feed, [1e-3, 1e5], "from 0.001 to 1e5 mm/s"),
            ("hop", self.hop, [1e-3, 1e5], "from 0.001 to 1e5 mm"),
        ];
        match ranges.into_iter().find(|(_, value, [min, max], _)| !(min..=max).contains(&value)) {
            Some((option, value, _, wanted)) => Err(TapeHeadError::Option { option, value, wanted }),
            None => Ok(()),
        }
    }

    /// The moves of the tapes of a layer, from the change of the tool to that back to the nozzle; none for no tape. On its way from tape to tape
    /// the head goes over these tapes; [`with_tapes`] knows what else is built.
    ///
    /// # Errors
    /// [`TapeHeadError`]; a tape that is shorter than the blade allows is one.
    ///
    /// # Cost
    /// `O(n)` for `n` points.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gcode::{FiberCommand, Move, Tool};
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
    /// use curvlay_toolpath::fiber::tapes::Tape;
    /// let points = vec![Point3::origin(), Point3::new(68.0, 0.0, 0.0)];
    /// let tape = Tape { points, normals: vec![Vector3::z_axis(); 2], width: 5.0, thickness: 0.08 };
    /// let layer = LayerTapes { layer: 0, tool: Tool::Roller, lift: 0.3, tapes: vec![tape] };
    /// let moves = TapeHead::default().moves(&layer)?;
    /// let cut = moves.iter().position(|step| *step == Move::Fiber(FiberCommand::Cut)).unwrap();
    /// // 20 mm are still to be laid, on top of the layer and under the roller.
    /// let Move::Lay { tip, .. } = moves[cut - 1] else { return Err("no tape before the cut".into()) };
    /// assert!((tip - Point3::new(48.0, 0.0, 0.38)).norm() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn moves(&self, layer: &LayerTapes) -> Result<Vec<Move>, TapeHeadError> {
        self.moves_over(layer, f64::NEG_INFINITY)
    }

    /// The same over what is built up to a height over the plate.
    fn moves_over(&self, layer: &LayerTapes, built_z: f64) -> Result<Vec<Move>, TapeHeadError> {
        self.check()?;
        if layer.tool == Tool::Nozzle {
            return Err(TapeHeadError::Tool { layer: layer.layer });
        }
        if !layer.lift.is_finite() {
            return Err(TapeHeadError::Layer { layer: layer.layer });
        }
        for (number, tape) in layer.tapes.iter().enumerate() {
            self.check_tape(layer, number, tape)?;
        }
        let clear_z = self.clear_z(layer, built_z);
        let mut moves = Vec::new();
        let fiber = |command: FiberCommand| Move::Fiber(command);
        for (number, tape) in layer.tapes.iter().enumerate() {
            if number == 0 {
                moves.push(fiber(FiberCommand::Tool(layer.tool)));
                moves.extend(self.heat(self.celsius, true));
            }
            self.lay(tape, layer.lift, clear_z, &mut moves);
        }
        if !moves.is_empty() {
            moves.extend(self.heat(0.0, false));
            moves.push(fiber(FiberCommand::Tool(Tool::Nozzle)));
        }
        Ok(moves)
    }

    /// A height that is clear of what is built up to another one, and of tapes.
    fn clear_z(&self, layer: &LayerTapes, built_z: f64) -> f64 {
        let tops = layer.tapes.iter().flat_map(|tape| (0..tape.points.len()).map(|k| contact(tape, layer.lift, k).0.z));
        tops.fold(built_z, f64::max) + self.hop
    }

    /// A cold roller has no temperature to wait for.
    fn heat(&self, celsius: f64, wait: bool) -> Option<Move> {
        (self.celsius > 0.0).then_some(Move::Fiber(FiberCommand::Heat { celsius, wait }))
    }

    fn check_tape(&self, layer: &LayerTapes, number: usize, tape: &Tape) -> Result<(), TapeHeadError> {
        let finite = tape.points.iter().all(|point| point.iter().all(|x| x.is_finite()));
        let units = tape.normals.iter().all(|normal| (normal.norm() - 1.0).abs() < 1e-6);
        let sizes = [tape.width, tape.thickness].iter().all(|size| *size > 0.0 && size.is_finite());
        if tape.points.len() < 2 || tape.points.len() != tape.normals.len() || !(finite && units && sizes) {
            return Err(TapeHeadError::Tape { layer: layer.layer, tape: number });
        }
        let (length, blade) = (tape.length(), self.blade);
        if length < blade {
            return Err(TapeHeadError::Short { layer: layer.layer, tape: number, length, blade });
        }
        Ok(())
    }

    /// A tape: above its start, down, along it with a cut on the way, and off it.
    fn lay(&self, tape: &Tape, lift: f64, clear_z: f64, moves: &mut Vec<Move>) {
        let contact = |k: usize| contact(tape, lift, k);
        let above = |(tip, direction): (Point3<f64>, UnitVector3<f64>)| Move::Travel {
            tip: tip + direction.into_inner() * self.hop,
            direction,
            feed_mm_s: self.travel_feed,
        };
        let (start, end) = (contact(0), contact(tape.points.len() - 1));
        let high = |to: Move| over(to, clear_z);
        moves.extend([high(above(start)), above(start)]);
        moves.push(Move::Fiber(FiberCommand::Feed { length_mm: self.blade }));
        moves.push(Move::Travel { tip: start.0, direction: start.1, feed_mm_s: self.travel_feed });
        moves.push(Move::Fiber(FiberCommand::Press { newtons: self.force_n }));
        let lay =
            |(tip, direction): (Point3<f64>, UnitVector3<f64>)| Move::Lay { tip, direction, feed_mm_s: self.lay_feed };
        let mut left = tape.length() - self.blade;
        let mut is_cut = false;
        for k in 1..tape.points.len() {
            let piece = (tape.points[k] - tape.points[k - 1]).norm();
            if !is_cut && left <= piece {
                is_cut = true;
                if left > 0.0 {
                    moves.push(lay(between(contact(k - 1), contact(k), left / piece)));
                }
                moves.push(Move::Fiber(FiberCommand::Cut));
                if left >= piece {
                    continue;
                }
            }
            left -= piece;
            moves.push(lay(contact(k)));
        }
        moves.extend([Move::Fiber(FiberCommand::Press { newtons: 0.0 }), above(end), high(above(end))]);
    }
}

/// Where the roller touches a tape, on top of it, and how it stands.
fn contact(tape: &Tape, lift: f64, k: usize) -> (Point3<f64>, UnitVector3<f64>) {
    (tape.points[k] + tape.normals[k].into_inner() * (lift + tape.thickness), tape.normals[k])
}

/// A travel, raised to a height over the plate unless it is higher.
fn over(travel: Move, z: f64) -> Move {
    match travel {
        Move::Travel { tip, direction, feed_mm_s } => {
            Move::Travel { tip: Point3::new(tip.x, tip.y, tip.z.max(z)), direction, feed_mm_s }
        }
        other => other,
    }
}

/// Part of the way from one contact to the next.
fn between(
    from: (Point3<f64>, UnitVector3<f64>),
    to: (Point3<f64>, UnitVector3<f64>),
    share: f64,
) -> (Point3<f64>, UnitVector3<f64>) {
    let direction = from.1.into_inner() * (1.0 - share) + to.1.into_inner() * share;
    (from.0 + (to.0 - from.0) * share, UnitVector3::try_new(direction, 1e-9).unwrap_or(to.1))
}

/// The moves of a print with those of its tapes in between: the tapes on a layer come where the next layer begins, those of the last one at the end.
///
/// # Arguments
/// * `moves`: with a [`Mark::Layer`] where each layer begins, as [`marked_moves`](crate::gcode::marked_moves) gives them.
/// * `tapes`: by layer, in order; a layer may come twice, with different tools.
///
/// # Errors
/// [`TapeHeadError`], before anything is given out.
///
/// # Cost
/// `O(1)` a move; the moves of the tapes are in memory.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{FiberCommand, Mark, Move, Tool};
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead, with_tapes};
/// use curvlay_toolpath::fiber::tapes::Tape;
/// let points = vec![Point3::origin(), Point3::new(40.0, 0.0, 0.0)];
/// let tape = Tape { points, normals: vec![Vector3::z_axis(); 2], width: 5.0, thickness: 0.08 };
/// let tapes = [LayerTapes { layer: 0, tool: Tool::Roller, lift: 0.3, tapes: vec![tape] }];
/// let layers = [0, 1].map(|number| Move::Mark(Mark::Layer { number, z_mm: 0.3, height_mm: 0.6 }));
/// let moves: Vec<Move> = with_tapes(layers, &tapes, &TapeHead::default())?.collect();
/// assert_eq!((moves[0], moves[1]), (layers[0], Move::Fiber(FiberCommand::Tool(Tool::Roller))));
/// assert_eq!(moves.last(), Some(&layers[1]));
/// # Ok::<(), curvlay_toolpath::fiber::head::TapeHeadError>(())
/// ```
pub fn with_tapes(
    moves: impl IntoIterator<Item = Move>,
    tapes: &[LayerTapes],
    head: &TapeHead,
) -> Result<impl Iterator<Item = Move>, TapeHeadError> {
    head.check()?;
    if let Some(pair) = tapes.windows(2).find(|pair| pair[1].layer < pair[0].layer) {
        return Err(TapeHeadError::Layer { layer: pair[1].layer });
    }
    tapes.iter().try_for_each(|layer| head.moves(layer).map(|_| ()))?;
    let (mut tapes, head) = (tapes.iter().peekable(), *head);
    // The last place of the nozzle, the highest bead, and the height at which the head has left the tapes.
    let (mut at, mut built_z, mut left_z) = (None, f64::NEG_INFINITY, None);
    let all = moves.into_iter().map(Some).chain([None]).flat_map(move |step| {
        let mut due = Vec::new();
        let next = match step {
            Some(Move::Mark(Mark::Layer { number, .. })) => number,
            None => u32::MAX,
            _ => 0,
        };
        while let Some(layer) = tapes.next_if(|layer| layer.layer < next) {
            // They have been checked.
            let moves = head.moves_over(layer, built_z).unwrap_or_default();
            let clear_z = head.clear_z(layer, built_z);
            if let Some((tip, direction)) = at.take().filter(|_| !moves.is_empty()) {
                due.push(over(Move::Travel { tip, direction, feed_mm_s: head.travel_feed }, clear_z));
            }
            left_z = if moves.is_empty() { left_z } else { Some(clear_z) };
            due.extend(moves);
        }
        match step {
            Some(Move::Print { tip, direction, .. }) => {
                at = Some((tip, direction));
                built_z = f64::max(built_z, tip.z);
            }
            Some(travel @ Move::Travel { tip, direction, .. }) => {
                // Over where the nozzle goes on, and down there.
                due.extend(left_z.take().map(|z| over(travel, z)));
                at = Some((tip, direction));
            }
            Some(Move::Home) => (at, left_z) = (None, None),
            _ => {}
        }
        due.into_iter().chain(step)
    });
    Ok(all)
}
