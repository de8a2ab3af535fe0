//! The ways in which parts are sought, one after the other, and which of them is best.

use super::{Args, Method};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_layers::Progress;
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::{
    AuditOptions, AuditedPart, BeamOptions, BuildSequence, Decomposition, Head, PartsAudit, TuningOptions, audit_parts,
    beam_search, lowest_pedestal, tune,
};
use std::time::{Duration, Instant};

/// A way in which parts were sought, and what it left.
pub struct Try {
    pub method: Method,
    pub pedestal_mm: f64,
    pub parts: usize,
    pub risky_mm2: f64,
    /// Whether the audit accepts it.
    pub is_accepted: bool,
}

/// With a pedestal so much less of the risky area must be left, as a share of all, that it is taken.
const PEDESTAL_GAIN: f64 = 0.02;

/// A pedestal is sought at so many times the radius of the head, and then lowered: with a head that looks down a little most is taken off.
const PEDESTAL_RADII: f64 = 2.0;

/// Parts that were found in some way, with the head and the pedestal that go with them.
pub struct Found {
    pub parts: Decomposition,
    pub head: Option<Head>,
    pub audit: PartsAudit,
    pub audit_time: Duration,
}

/// The ways in which parts were sought.
pub struct Ways {
    /// In the order in which they were tried.
    pub tries: Vec<Try>,
    /// Which of them was taken.
    pub taken: usize,
}

impl Found {
    /// Whether neither risky area nor the audit says that it fails.
    fn passes(&self, args: &Args) -> bool {
        self.parts.risky_mm2() <= args.allow_risky * self.parts.risky_before_mm2 && self.audit.is_ok
    }

    fn pedestal_mm(&self) -> f64 {
        self.head.map_or(0.0, |head| head.pedestal)
    }

    /// Whether it is worth more than another one.
    fn is_better(&self, known: &Found, args: &Args) -> bool {
        if self.passes(args) != known.passes(args) {
            return self.passes(args);
        }
        let extra = if self.pedestal_mm() > known.pedestal_mm() { PEDESTAL_GAIN } else { 0.0 };
        self.parts.risky_mm2() + extra * self.parts.risky_before_mm2 < known.parts.risky_mm2()
    }
}

/// Seeks parts in one way after the other until they pass; the best.
pub fn sought(
    args: &Args,
    solid: &Solid,
    sequence: &BuildSequence,
    tuning: &TuningOptions,
    bars: &Bars,
) -> Result<(Found, Ways), Failure> {
    let show = |at: Progress| bars.show(at.stage, at.done, at.total);
    let methods: &[Method] = match args.method {
        Method::Auto => &[Method::Robofdm, Method::Beam],
        Method::Robofdm => &[Method::Robofdm],
        Method::Beam => &[Method::Beam],
    };
    let pedestals = match (args.pedestal_mm, tuning.head) {
        (Some(height), _) => vec![height],
        (None, Some(head)) => vec![0.0, PEDESTAL_RADII * head.radius(f64::INFINITY)],
        (None, None) => vec![0.0],
    };
    let mut best: Option<(Found, usize)> = None;
    let mut tries: Vec<Try> = Vec::new();
    for (pedestal, &method) in pedestals.iter().flat_map(|&height| methods.iter().map(move |method| (height, method))) {
        let with = |pedestal: f64| tuning.head.map(|head| Head { pedestal, ..head });
        let tuning = TuningOptions { head: with(pedestal), ..*tuning };
        let parts = if method == Method::Beam {
            let options = BeamOptions { tuning, width: usize::from(args.width), ..BeamOptions::default() };
            beam_search(solid, Some(sequence), &options, &show)?
        } else {
            tune(solid, sequence, &tuning, &show)?
        };
        let wanted = with(pedestal).filter(|_| args.pedestal_mm.is_none());
        let head = with(wanted.map_or(pedestal, |head| lowest_pedestal(solid, &parts.parts, &head)));
        let start = Instant::now();
        let audited: Vec<AuditedPart> = parts.parts.iter().map(|part| part.audited()).collect();
        let options = AuditOptions {
            max_angle: tuning.max_angle,
            head,
            max_unsupported: args.allow_unsupported,
            ..AuditOptions::default()
        };
        let audit = audit_parts(solid, &audited, &options, &show)?;
        let found = Found { parts, head, audit, audit_time: start.elapsed() };
        tries.push(Try {
            method,
            pedestal_mm: found.pedestal_mm(),
            parts: found.parts.parts.len(),
            risky_mm2: found.parts.risky_mm2(),
            is_accepted: found.audit.is_ok,
        });
        let passes = found.passes(args);
        if best.as_ref().is_none_or(|(known, _)| found.is_better(known, args)) {
            best = Some((found, tries.len() - 1));
        }
        if passes {
            break;
        }
    }
    let Some((best, taken)) = best else { unreachable!("there is a way in which parts are sought") };
    Ok((best, Ways { tries, taken }))
}
