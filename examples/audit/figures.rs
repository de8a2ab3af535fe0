//! What the checks found: figures, places, and why a figure is absent.

use curvlay_examples::count::counted;
use curvlay_examples::findings::Finding;
use nalgebra::Point3;

/// What is looked for, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The nozzle cannot reach it without touching what is built before.
    Shadowed,
    /// Nothing near enough below carries it.
    Unsupported,
    /// Nothing at all is within a bead below it.
    InAir,
    /// The nozzle, as the input directs it, cuts what was laid before.
    Gouged,
    /// Volume of the part that nothing covers.
    Uncovered,
    /// Nothing of the part is there.
    Outside,
    /// It is laid where something lies.
    LaidTwice,
}

impl Check {
    /// All of them.
    pub const ALL: [Check; 7] = [
        Check::Shadowed,
        Check::Unsupported,
        Check::InAir,
        Check::Gouged,
        Check::Uncovered,
        Check::Outside,
        Check::LaidTwice,
    ];

    /// Its name in keys of the summary.
    pub fn key(self) -> &'static str {
        match self {
            Check::Shadowed => "shadowed",
            Check::Unsupported => "unsupported",
            Check::InAir => "in_air",
            Check::Gouged => "gouged",
            Check::Uncovered => "uncovered",
            Check::Outside => "outside",
            Check::LaidTwice => "laid_twice",
        }
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Check::InAir => "in the air",
            Check::LaidTwice => "laid twice",
            other => other.key(),
        }
    }

    /// What is wrong, in plain words.
    pub fn what(self) -> &'static str {
        match self {
            Check::Shadowed => "the nozzle cannot reach it without touching what is built before",
            Check::Unsupported => "nothing near enough below carries it",
            Check::InAir => "nothing is within a bead below it",
            Check::Gouged => "the nozzle cuts what was laid before",
            Check::Uncovered => "part of the volume is covered by nothing",
            Check::Outside => "material lies outside of the part",
            Check::LaidTwice => "material is laid where some lies",
        }
    }
}

/// A place of a finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where, in the frame of the input.
    pub at: Point3<f64>,
    /// The layer, from 1, where there are layers.
    pub layer: Option<u32>,
    /// How bad: the worst comes first.
    pub size: f64,
}

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// How much.
    pub amount: f64,
    /// Of what: `cells`, `mm`, `mm2`, `mm3`.
    pub unit: &'static str,
    /// As a share of all, where that says something.
    pub share: Option<f64>,
    /// Further figures, with their keys.
    pub more: Vec<(&'static str, f64)>,
    /// Where, the worst first; some of them.
    pub places: Vec<Place>,
    /// Words behind it in the table.
    pub note: String,
}

/// What a check says.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It could be made.
    Found(Found),
    /// It does not apply, and why.
    Absent(String),
}

/// Places that a check lists at most.
pub const MAX_PLACES: usize = 20;

impl Found {
    /// Sorts the places and keeps the worst; equal ones stay in the order of the build.
    pub fn with_places(mut self, mut places: Vec<Place>) -> Self {
        places.sort_by(|a, b| b.size.total_cmp(&a.size));
        places.truncate(MAX_PLACES);
        self.places = places;
        self
    }

    /// The amount in words.
    pub fn shown(&self) -> String {
        match self.unit {
            "cells" => counted(self.amount, "cell"),
            unit => format!("{:.1} {unit}", self.amount),
        }
    }
}

/// What an input lays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Laid {
    /// Cells.
    #[default]
    Cells,
    /// Beads.
    Beads,
    /// Surfaces of layers.
    Layers,
}

/// An audit.
#[derive(Clone, Debug, Default)]
pub struct Audited {
    /// Verdicts, each check once.
    pub verdicts: Vec<(Check, Verdict)>,
    /// What was audited: figures with their keys, and words for the table.
    pub about: Vec<(&'static str, f64)>,
    /// How the input was understood, in words.
    pub meant: String,
    /// What was laid, by whose options it was judged.
    pub laid: Laid,
    /// Sizes that are no print's, in words.
    pub slips: Vec<String>,
    /// What was decided on the way.
    pub notes: Vec<Finding>,
    /// Pictures with their captions.
    pub pictures: Vec<(String, Vec<u8>)>,
}

impl Audited {
    /// Adds a verdict.
    pub fn set(&mut self, check: Check, verdict: Verdict) {
        self.verdicts.push((check, verdict));
    }

    /// Adds a check that does not apply.
    pub fn absent(&mut self, check: Check, why: impl Into<String>) {
        self.set(check, Verdict::Absent(why.into()));
    }

    /// Verdicts in the order of the table.
    pub fn in_order(&self) -> impl Iterator<Item = (Check, &Verdict)> {
        let of =
            |check: Check| self.verdicts.iter().find(move |(known, _)| *known == check).map(|(_, verdict)| verdict);
        Check::ALL.into_iter().filter_map(move |check| Some((check, of(check)?)))
    }
}
