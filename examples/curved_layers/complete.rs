//! How a part is made complete: the options of the command line, and what came of them.

use clap::{Args, ValueEnum};
use curvlay_examples::args::{from_zero, typed_name};
use curvlay_layers::curved::{self, DirectedOptions, LayerOptions, NozzleRule, NozzleUse, SupportOptions};
use curvlay_toolpath::gouging::{Nozzle, NozzleShape};

/// Cells that no order builds by the hull rule.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cells that the hull rule does not let build")]
pub struct CompleteArgs {
    /// By what the order of the cells is found [default: best; hull where layers are as high as cells, unless there is a mould (--on), with a --strategy other than best,
    /// --nozzle-growth or --coherent]
    #[arg(long, value_enum, conflicts_with = "resume")]
    pub layers_by: Option<LayersBy>,
    /// When cells are judged by the nozzle that prints in place of the hull rule, which holds for nozzles of any size [default: after;
    /// off with a --strategy other than best]
    #[arg(long, value_enum, conflicts_with = "resume")]
    pub nozzle_growth: Option<NozzleGrowth>,
    /// How far that nozzle may lean, in degrees: above 0, up to 90
    #[arg(long = "max-tilt", value_name = "DEGREES", default_value_t = 90.0, value_parser = tilt, allow_negative_numbers = true)]
    pub max_tilt_deg: f64,
    /// How far directed layers lean from level at most, in degrees: 0 up to less than 90 [default: 6 degrees less than the cone of the nozzle leaves
    /// of a right angle, 39 at least]
    #[arg(long = "max-layer-tilt", value_name = "DEGREES", value_parser = layer_tilt, allow_negative_numbers = true, conflicts_with = "resume")]
    pub max_layer_tilt_deg: Option<f64>,
    /// Radius of the balls that stand for cells that are built, in cells: 0.5 is a bead as wide as a cell
    #[arg(long = "nozzle-margin", value_name = "CELLS", default_value_t = 0.5, value_parser = margin, allow_negative_numbers = true)]
    pub nozzle_margin_cells: f64,
    /// Support for cells that are missed all the same, and for unsupported beads [default: auto; none with a --strategy other than best]
    #[arg(long, value_enum, conflicts_with = "resume")]
    pub support: Option<Support>,
    /// Width of the columns of support, in cells
    #[arg(long = "support-width", value_name = "CELLS", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=i64::from(SupportOptions::MAX_WIDTH)))]
    pub support_width_cells: u32,
    /// And where they touch the part, in cells: narrower, so that they break off
    #[arg(long = "support-contact", value_name = "CELLS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(SupportOptions::MAX_WIDTH)))]
    pub support_contact_cells: u32,
    /// Levels of cells that stay empty between support and part; cells over such a gap count as supported, beads over it do not
    #[arg(long = "support-gap", value_name = "CELLS", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=i64::from(SupportOptions::MAX_WIDTH)))]
    pub support_gap_cells: u32,
    /// Share of the inside of support that is filled
    #[arg(long = "support-density", value_name = "PERCENT", default_value_t = 25.0, value_parser = percent, allow_negative_numbers = true)]
    pub support_density_percent: f64,
}

/// By what the order is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayersBy {
    /// By convex hulls, which let a nozzle of any size pass.
    Hull,
    /// By the distance from what the part stands on, inside the part, within the reach of the nozzle: layers that do not tear.
    Distance,
    /// By the distance, leaning from upright no more than the cone of the nozzle allows; half layers where layers are thick.
    Directed,
    /// Directed, then by the distance, then by hulls: the first whose print passes all checks, else the one that is nearest to it. With --stage field,
    /// --stage surfaces, --layers or --merge nothing is printed to choose by: the first that misses no cell, else the one that misses the fewest.
    /// --stage preview takes the first that misses no more than --allow-missed.
    Best,
}

impl From<LayersBy> for curved::LayersBy {
    fn from(layers_by: LayersBy) -> Self {
        match layers_by {
            LayersBy::Hull => curved::LayersBy::Hull,
            LayersBy::Distance => curved::LayersBy::Distance,
            LayersBy::Directed => curved::LayersBy::Directed,
            LayersBy::Best => curved::LayersBy::Best,
        }
    }
}

impl From<curved::LayersBy> for LayersBy {
    fn from(layers_by: curved::LayersBy) -> Self {
        match layers_by {
            curved::LayersBy::Hull => LayersBy::Hull,
            curved::LayersBy::Distance => LayersBy::Distance,
            curved::LayersBy::Directed => LayersBy::Directed,
            curved::LayersBy::Best => LayersBy::Best,
        }
    }
}

/// When cells are judged by the nozzle that prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NozzleGrowth {
    /// Never.
    Off,
    /// After the order by the hull rule: what that misses.
    After,
    /// From the start on: each cell is built by either rule.
    FromStart,
}

/// Whether there is support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Support {
    /// None.
    None,
    /// Below what is missed, if less is missed with it; of directed layers and those by distance also below unsupported beads, where they are more than the --allow options
    /// permit.
    Auto,
}

impl CompleteArgs {
    /// As they hold with the best strategy, or with one that was asked for: strategies are compared by what they miss.
    pub fn with_strategy(self, is_best: bool) -> (NozzleGrowth, Support) {
        let growth = if is_best { NozzleGrowth::After } else { NozzleGrowth::Off };
        let support = if is_best { Support::Auto } else { Support::None };
        (self.nozzle_growth.unwrap_or(growth), self.support.unwrap_or(support))
    }

    /// As layering takes them.
    pub fn options(self, layers_by: LayersBy, is_best: bool, nozzle: &Nozzle) -> LayerOptions {
        let (growth, support) = self.with_strategy(is_best);
        let NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm } = nozzle.shape();
        let rule = NozzleRule {
            tip_flat_mm,
            half_angle,
            cone_height_mm,
            block_mm,
            max_tilt: self.max_tilt_deg.to_radians(),
            margin: self.nozzle_margin_cells,
        };
        let nozzle = match growth {
            NozzleGrowth::Off => NozzleUse::Off,
            NozzleGrowth::After => NozzleUse::After,
            NozzleGrowth::FromStart => NozzleUse::FromStart,
        };
        let layers_by = layers_by.into();
        let (width, contact, gap) = (self.support_width_cells, self.support_contact_cells, self.support_gap_cells);
        let columns = SupportOptions { width, contact, gap, ..SupportOptions::default() };
        let directed = DirectedOptions { max_tilt: self.max_layer_tilt_deg.map(f64::to_radians) };
        let support = (support == Support::Auto).then_some(columns);
        LayerOptions { layers_by, nozzle, rule, directed, support, ..LayerOptions::default() }
    }

    /// Says what does not go together.
    pub fn check(self) -> Result<(), String> {
        let CompleteArgs { support_width_cells: width, support_contact_cells: contact, .. } = self;
        if contact > width {
            return Err(format!("--support-contact {contact} is above --support-width {width}"));
        }
        Ok(())
    }

    /// The names of what holds.
    pub fn names(self, is_best: bool) -> [String; 2] {
        let (growth, support) = self.with_strategy(is_best);
        [typed_name(growth), typed_name(support)]
    }
}

fn tilt(text: &str) -> Result<f64, String> {
    let degrees = from_zero(text)?;
    if degrees > 0.0 && degrees <= 90.0 {
        Ok(degrees)
    } else {
        Err("must be above 0 and at most 90; to print upright alone use --nozzle-growth off".to_owned())
    }
}

fn layer_tilt(text: &str) -> Result<f64, String> {
    from_zero(text).ok().filter(|degrees| *degrees < 90.0).ok_or_else(|| "must be from 0 to less than 90".to_owned())
}

fn percent(text: &str) -> Result<f64, String> {
    from_zero(text).ok().filter(|percent| *percent <= 100.0).ok_or_else(|| "must be from 0 to 100".to_owned())
}

fn margin(text: &str) -> Result<f64, String> {
    from_zero(text).ok().filter(|cells| *cells <= 1.0).ok_or_else(|| "must be from 0 to 1".to_owned())
}
