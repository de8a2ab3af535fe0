//! The arguments as the stages take them.

use crate::args::{Args, Extra, Stage, failure};
use crate::choice;
use crate::complete::{LayersBy, Support};
use crate::estimate::Memory;
use crate::field::FieldOptions;
use crate::guide::Guide;
use crate::job::Posed;
use crate::preview;
use crate::ranges::LayerFill;
use crate::surfaces::{SurfaceOptions, SurfacesRun};
use clap::ArgMatches;
use curvlay_examples::args::{Failure, GrowArgs, Part, is_typed, typed_name};
use curvlay_examples::bars::Bars;
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::orienting::{laid, search};
use curvlay_examples::settings::{BEAD_MM, LAYER_HEIGHT_MM, Profile};
use curvlay_examples::shapes::{jug, small_jug};
use curvlay_layers::curved::orient::PoseKind;
use curvlay_layers::curved::surface::{SavedField, mesh_stamp};
use curvlay_layers::curved::{LayerOptions, Rules};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::gcode::WriteError;
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::path::PathOptions;
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::support::SupportOptions;
use std::path::Path;
use std::time::Instant;

impl Args {
    /// Puts what is typed over the profile, and says what does not go together.
    pub fn with_profile(mut self, matches: &ArgMatches) -> Result<Self, Failure> {
        if let Some(path) = &self.profile {
            self.settings = Profile::load(path)?.below(self.settings, matches);
        }
        if self.layers.is_some() {
            self.stage = Stage::Paths;
        }
        let DepositionOptions { min_feed, max_feed, .. } = self.settings.deposition();
        if min_feed > max_feed {
            return Err(Failure::of_arguments(format!("--min-feed {min_feed} is above --max-feed {max_feed}")));
        }
        self.complete.check().map_err(Failure::of_arguments)?;
        if self.complete.max_layer_tilt_deg.is_some() && matches!(self.layers_by(), LayersBy::Hull | LayersBy::Distance)
        {
            let name = typed_name(self.layers_by());
            let why = format!("--max-layer-tilt does nothing with --layers-by {name}: it needs directed or best");
            return Err(Failure::of_arguments(why));
        }
        if self.settings.price_per_kg.is_some() && self.settings.material_density_g_cm3.is_none() {
            return Err(Failure::of_arguments("--price-per-kg needs --material-density: filament is sold by mass"));
        }
        let has_beads = self.stage >= Stage::Paths || self.stage == Stage::Preview;
        if let Some(height_mm) = self.height().or(self.voxel.cell).filter(|_| has_beads) {
            self.bead(height_mm).map_err(Failure::of_arguments)?;
        }
        if !self.motion.cell8 && self.motion.workcell.is_none() {
            self.motion.workcell = self.settings.workcell.take();
        }
        self.loaded_flavour = self.settings.load_flavour()?;
        self.printer = self.machine.as_deref().map(FiveAxisPrinter::load).transpose()?;
        self.check_machine_file(matches)?;
        Ok(self)
    }

    /// What would be wrong with the machine file however the part looks.
    fn check_machine_file(&self, matches: &ArgMatches) -> Result<(), Failure> {
        let of_profile = |error: WriteError| match &self.profile {
            Some(path) => failure(format!("{}: {error}", path.display())),
            None => failure(error),
        };
        let Some(flavour) = &self.loaded_flavour else {
            return self.settings.check_templates().map_err(of_profile);
        };
        if let Some(id) = ["dialect", "extrusion", "line_numbers"].into_iter().find(|id| is_typed(matches, id)) {
            let (option, name) = (id.replace('_', "-"), &flavour.name);
            let why = format!("--{option} does nothing in the flavour `{name}`, which says it itself: change its JSON");
            return Err(Failure::of_arguments(why));
        }
        self.settings.check_flavour(flavour).map_err(of_profile)
    }

    /// The files that it reads.
    pub fn files(&self) -> impl Iterator<Item = Option<&Path>> {
        let one = [&self.resume, &self.profile, &self.motion.workcell, &self.machine];
        let guides = [&self.mould, &self.base, &self.directions];
        let flavour = self.settings.flavour.as_deref().map(Path::new);
        one.into_iter()
            .chain(guides)
            .map(Option::as_deref)
            .chain([self.mesh.path(), flavour])
            .chain(self.merge.iter().map(|path| Some(path.as_path())))
    }

    /// Whether it is said what cells there are, in one way or another: then layers and beads follow from them.
    pub fn has_cells(&self) -> bool {
        self.resume.is_some() || self.voxel.resolution().is_some()
    }

    /// The part. Without a mesh it is a jug: a small one where layers are as those of printers, otherwise it would take too long. A field goes
    /// on with the jug that it is of.
    pub fn part(&self, saved: Option<&SavedField>) -> Result<Part, Failure> {
        let load = |shape: fn() -> Mesh| self.mesh.load("jug (made in code)", shape);
        if self.mesh.path().is_some() || self.voxel.resolution().is_some() {
            return Ok(load(jug)?);
        }
        let small = load(small_jug)?;
        let is_of =
            |saved: &SavedField| saved.check_mesh(mesh_stamp(&small.mesh.vertices, &small.mesh.triangles)).is_ok();
        if saved.is_none_or(is_of) { Ok(small) } else { Ok(load(jug)?) }
    }

    /// What it is built on.
    pub fn mould(&self) -> Result<Option<Part>, Failure> {
        Ok(self.mould.as_deref().map(|path| self.mesh.load_file(path)).transpose()?)
    }

    /// Layer height; `None` for the edge of a cell.
    pub fn height(&self) -> Option<f64> {
        self.settings.layer_height_mm.or(if self.has_cells() { None } else { Some(LAYER_HEIGHT_MM) })
    }

    /// Width of a bead where layers are so high.
    pub fn bead(&self, height_mm: f64) -> Result<f64, String> {
        let (settings, has_cells) = (&self.settings, self.has_cells());
        if settings.bead_mm.is_none() && has_cells && settings.layer_height_mm.is_none() {
            return Ok(height_mm);
        }
        // Layers are stretched a little, up or down, so that they fill the part: what counts is what was asked for.
        let asked_mm = self.height().or(self.voxel.cell).unwrap_or(height_mm);
        let bead_mm = settings.bead_mm.unwrap_or(if has_cells { height_mm.max(asked_mm) } else { BEAD_MM });
        let height_mm = asked_mm;
        if height_mm <= bead_mm {
            return Ok(bead_mm);
        }
        let origin = |is_given, otherwise| if is_given { "" } else { otherwise };
        let height_is = if has_cells { ", the edge of a cell," } else { ", the default," };
        let height_is = origin(settings.layer_height_mm.is_some(), height_is);
        let bead_is = origin(settings.bead_mm.is_some(), ", the default");
        let height_mm = (height_mm * 1e3).round() / 1e3;
        Err(format!(
            "layers of {height_mm} mm{height_is} are higher than a bead is wide, {bead_mm} mm{bead_is}: see --layer-height and --bead"
        ))
    }

    /// Whether a file is to be written: asked for, or one of the field and its layers in a run for research. With layers as those of
    /// printers they take hundreds of megabytes.
    pub fn writes(&self, extra: Extra) -> bool {
        let is_of_research = self.has_cells() && self.stage != Stage::Preview;
        self.also.contains(&extra) || (is_of_research && extra.stage() <= Stage::Surfaces)
    }

    /// By what the order of the cells is found: by what prints best, unless the run is for research, or the user asks for something that only orders by hulls
    /// have.
    pub fn layers_by(&self) -> LayersBy {
        if let Some(layers_by) = Guide::layers_by(self) {
            return layers_by;
        }
        let is_by_hulls = self.grow.strategy().is_some() || self.complete.nozzle_growth.is_some() || self.coherent;
        // A hull that holds a mould holds much of the part.
        let is_for_research = self.height().is_none() && self.mould.is_none();
        let default = if is_by_hulls || is_for_research { LayersBy::Hull } else { LayersBy::Best };
        self.complete.layers_by.unwrap_or(default)
    }

    /// Whether orders are printed to choose among them, or to find out where beads are unsupported. Ranges of layers, and the run that puts them together, have to agree on
    /// the order before.
    pub fn chooses_by_print(&self) -> bool {
        let is_in_ranges = self.layers.is_some() || !self.merge.is_empty();
        let is_to_choose = self.layers_by() == LayersBy::Best || self.supports_beads(self.layers_by());
        is_to_choose && self.stage >= Stage::Gcode && self.resume.is_none() && !is_in_ranges
    }

    /// The orders that are tried, one after the other, until one passes all checks.
    pub fn orders(&self) -> Vec<LayersBy> {
        match self.layers_by() {
            LayersBy::Best => choice::orders().to_vec(),
            layers_by => vec![layers_by],
        }
    }

    /// Whether unsupported beads of an order get support: orders by hulls are as the works have them.
    pub fn supports_beads(&self, layers_by: LayersBy) -> bool {
        let (_, support) = self.complete.with_strategy(self.grow.strategy().is_none());
        layers_by != LayersBy::Hull && support == Support::Auto
    }

    pub fn field_options(&self, layers_by: LayersBy, nozzle: &Nozzle) -> FieldOptions {
        let GrowArgs { eps_cells, beyond_eps, .. } = self.grow;
        let (resolution, strategy, height_mm) = (self.voxel.resolution(), self.grow.strategy(), self.height());
        let platform_diameter_mm = self.platform_diameter_mm();
        let complete = self.complete.options(layers_by, strategy.is_none(), nozzle);
        let layers = LayerOptions { strategy, height_mm, ..complete };
        let max_cells = (self.stage == Stage::Preview).then_some(preview::MAX_CELLS);
        FieldOptions { resolution, max_cells, eps_cells, beyond_eps, platform_diameter_mm, layers }
    }

    /// Turns the part into its best pose.
    pub fn lay(&self, part: &mut Part, bars: &Bars) -> Result<Posed, Failure> {
        let start = Instant::now();
        let GrowArgs { eps_cells, beyond_eps, .. } = self.grow;
        let rules = Rules { inside_depth_cells: eps_cells, boundary_is_inside: !beyond_eps, ..Rules::default() };
        let options = self.posing.options(rules, self.platform_diameter_mm());
        let search = search(&part.mesh, &self.posing, &options, bars)?;
        let best = search.best().pose;
        if best.kind != PoseKind::Given {
            part.mesh = laid(&part.mesh, &best);
            let [x, y, z] = best.up.into_inner().into();
            part.warnings
                .push(format!("the part was turned: its direction {x:.3} {y:.3} {z:.3} points up (oriented.obj)"));
        }
        Ok(Posed { search, time: start.elapsed() })
    }

    pub fn platform_diameter_mm(&self) -> f64 {
        self.settings.platform_diameter_mm
    }

    pub fn memory(&self) -> Memory {
        Memory(self.max_memory_gb)
    }

    pub fn surface_options(&self) -> SurfaceOptions {
        let max_surfaces = (self.stage == Stage::Preview).then_some(preview::MAX_SURFACES);
        let layers = self.layers.map(|pick| (pick, self.neighbours()));
        SurfaceOptions {
            height_mm: self.height(),
            max_surfaces,
            coherent: self.coherent,
            compare: self.compare,
            layers,
        }
    }

    /// How many layers before and after one take part in how it is filled: skins are where one of them is missing. Those of support are one layer thick.
    fn neighbours(&self) -> usize {
        let infill = self.settings.infill();
        let of_part = if infill.is_solid() { 0 } else { infill.skin as usize };
        of_part.max(usize::from(self.complete.support_density_percent < 100.0))
    }

    pub fn path_options(&self, height_mm: f64) -> Result<PathOptions, Failure> {
        let (bead, pattern) = (self.bead(height_mm).map_err(failure)?, self.pattern.of_surface());
        let &Args { min_gap_squares: min_gap, join_distance_beads: join_distance, .. } = self;
        let &Args { min_length_beads: min_length, min_width_beads: min_width, .. } = self;
        let (infill, coverage) = (self.settings.infill(), self.has_statistics());
        Ok(PathOptions {
            bead,
            pattern,
            min_gap,
            join_distance,
            min_length,
            min_width,
            infill,
            coverage,
            ..PathOptions::default()
        })
    }

    /// How the layers are filled, and their support if there is any.
    pub fn fill(&self, part: PathOptions, surfaces: &SurfacesRun) -> LayerFill {
        let density = self.complete.support_density_percent / 100.0;
        LayerFill { part, support: surfaces.support.as_ref().map(|_| part.for_support(density)) }
    }

    /// Whether what beads cover is measured.
    pub fn has_statistics(&self) -> bool {
        self.statistics || self.compare
    }

    pub fn support_options(&self) -> SupportOptions {
        SupportOptions { max_distance: self.support_distance_heights, ..SupportOptions::default() }
    }

    pub fn print_options(&self) -> PrintOptions {
        let is_for_robot = self.stage >= Stage::Motion;
        let options = if is_for_robot { PrintOptions::for_robot() } else { PrintOptions::default() };
        let gouging = self.settings.gouging(options.gouging);
        PrintOptions { gouging, travel: self.settings.travel(), deposition: self.settings.deposition(), ..options }
    }
}
