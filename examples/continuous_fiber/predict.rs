//! Stiffness from the lay-up beside what the dissertation measured (section 5.4), with what is assumed.

use super::specimens::{DUMBBELL_MM, Specimen};
use curvlay_toolpath::surface::{
    LayUp, SandwichLayer, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2,
};

/// Young's modulus of the dumbbells without and with fibre, in GPa (section 5.4.1).
pub const MEASURED_GPA: [f64; 2] = [1.25, 2.32];
/// Flexural rigidity of the bars without and with fibre, in N m^2 (section 5.4.1).
pub const MEASURED_NM2: [f64; 2] = [0.351, 0.671];
/// Force per displacement of the arcs, in N/mm: planar layers (PU), curved layers (CU), curved layers with fibre (CR) (section 5.4.2).
pub const MEASURED_N_MM: [f64; 3] = [11.35, 12.43, 16.54];

/// Modulus of the fibre in GPa: Pyrofil TR50S, data sheet of Mitsubishi Chemical.
pub const FIBER_GPA: f64 = 235.0;
/// Mass of a tow of 15,000 filaments, mg/m, and density of the fibre, g/cm^3: the same data sheet (TR50S 15L).
const TOW_TEX: f64 = 1000.0;
const FIBER_G_CM3: f64 = 1.82;
/// The spread tow is 15 mm wide, and split into three (section 5.3.2).
const TOW_MM: f64 = 15.0;

/// Solid fibre in the section of a tape of a width, in mm^2: what the tow has, by its share of the width.
pub fn fiber_mm2(width_mm: f64) -> f64 {
    TOW_TEX * 1e-3 / FIBER_G_CM3 * width_mm / TOW_MM
}

/// A figure of ours beside the measured one.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// What it is.
    pub what: &'static str,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// By theory.
    pub ours: f64,
    /// In the dissertation.
    pub measured: f64,
    /// What is assumed.
    pub assumed: String,
    /// What may be the reason where they differ.
    pub remark: &'static str,
}

/// The figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    /// In tension, in GPa.
    pub modulus_gpa: f64,
    /// In bending, in N m^2.
    pub rigidity_nm2: f64,
    /// All of them, for the table.
    pub list: Vec<Prediction>,
}

fn lay_up(specimen: &Specimen, schedule: &[SandwichLayer], matrix_gpa: f64) -> LayUp {
    let [width_mm, height_mm] = specimen.section_mm();
    let tape = |(number, layer): (usize, &SandwichLayer)| {
        let at_mm = (number as f64 + 1.0) * specimen.layer_mm;
        layer.carries_tape.then(|| TapeInSection { at_mm, fiber_mm2: fiber_mm2(specimen.tape_mm[1]) })
    };
    let tapes = schedule.iter().enumerate().filter_map(tape).collect();
    LayUp { width_mm, height_mm, matrix_gpa, fiber_gpa: FIBER_GPA, tapes }
}

/// Predicts what the tests of the dissertation would show if fibre and thermoplastic were one.
///
/// The modulus of the thermoplastic is that of the specimens without fibre in the same test, so what is compared is what the fibre does.
pub fn predict(specimens: &[(Specimen, &[SandwichLayer]); 3]) -> Result<Predictions, StiffnessError> {
    let [(dumbbell, in_tension), (bar, in_bending), (arc, curved)] = specimens;
    let tension = lay_up(dumbbell, in_tension, MEASURED_GPA[0]);
    // EI of a plain bar gives back its modulus.
    let plain = LayUp { tapes: Vec::new(), ..lay_up(bar, in_bending, 1.0) };
    let matrix_gpa = MEASURED_NM2[0] / plain.rigidity_nm2()?;
    let bending = lay_up(bar, in_bending, matrix_gpa);
    let arch = lay_up(arc, curved, matrix_gpa);
    let (modulus_gpa, rigidity_nm2) = (tension.modulus_gpa()?, bending.rigidity_nm2()?);
    let fiber = format!(
        "{:.3} mm² of fibre a tape (TR50S 15K: 1000 tex, 1.82 g/cm³, a third of the tow), {FIBER_GPA} GPa",
        fiber_mm2(5.0)
    );
    let mut list = vec![
        Prediction {
            what: "tensile modulus of the reinforced dumbbell",
            unit: "GPa",
            ours: modulus_gpa,
            measured: MEASURED_GPA[1],
            assumed: format!(
                "rule of mixtures; thermoplastic {} GPa as measured without fibre; section {} x {DUMBBELL_MM} mm (ASTM D638 type I: the dissertation gives none); {fiber}; {:.1} % fibre",
                MEASURED_GPA[0],
                tension.width_mm,
                100.0 * tension.fiber_fraction()?
            ),
            remark: "the dry tow is ironed on by hand: most filaments have no thermoplastic around them and slip, and grips strain the ends; perfect bonds are an upper bound",
        },
        Prediction {
            what: "flexural rigidity of the reinforced bar",
            unit: "N m²",
            ours: rigidity_nm2,
            measured: MEASURED_NM2[1],
            assumed: format!(
                "layered beam; thermoplastic {matrix_gpa:.2} GPa from the rigidity without fibre ({} N m²); tapes between layers of {} mm; {fiber}",
                MEASURED_NM2[0], bar.layer_mm
            ),
            remark: "perfect bonds are an upper bound, as in tension",
        },
    ];
    list.extend(arches(arc, &arch, &fiber)?);
    Ok(Predictions { modulus_gpa, rigidity_nm2, list })
}

/// The arcs by their ratios: how they were held is not known well enough for their stiffness itself.
fn arches(arc: &Specimen, arch: &LayUp, fiber: &str) -> Result<Vec<Prediction>, StiffnessError> {
    let Some((radius, half)) = arc.arc() else { return Ok(Vec::new()) };
    let plain = LayUp { tapes: Vec::new(), ..arch.clone() }.rigidity_nm2()?;
    // The tapes end before the ends of the arc.
    let taped = (arc.tape_mm[0] / 2.0 / radius).min(half);
    let curved = arch_stiffness_n_mm(radius, half, &[(half, plain)])?;
    let reinforced = arch_stiffness_n_mm(radius, half, &[(taped, arch.rigidity_nm2()?), (half, plain)])?;
    let [planar_n_mm, curved_n_mm, reinforced_n_mm] = MEASURED_N_MM;
    Ok(vec![
        Prediction {
            what: "stiffness of the curved arc, CU",
            unit: "N/mm",
            ours: curved,
            measured: curved_n_mm,
            assumed: format!(
                "thin arch, ends slide, pressed at the crown; thermoplastic {:.2} GPa as in the bar",
                arch.matrix_gpa
            ),
            remark: "the arcs are printed at 210 °C, the bar at 230 °C; the edges sink in, and the table yields",
        },
        Prediction {
            what: "curved layers with fibre to without, CR/CU",
            unit: "",
            ours: reinforced / curved,
            measured: reinforced_n_mm / curved_n_mm,
            assumed: format!(
                "the same; tapes over {:.0} of {:.0} degrees; {fiber}",
                2.0 * taped.to_degrees(),
                2.0 * half.to_degrees()
            ),
            remark: "perfect bonds are an upper bound, as in tension",
        },
        Prediction {
            what: "planar layers to curved layers, PU/CU",
            unit: "",
            ours: 1.0,
            measured: planar_n_mm / curved_n_mm,
            assumed: "the same modulus along and across layers".to_owned(),
            remark: "beam theory knows no direction of layers: the seams between planar layers, and their steps, cost 9 %",
        },
    ])
}

/// `P L^3 / (48 d)` of the bar as the dissertation tests it, for the report: the deflection that the predicted rigidity stands for.
pub fn deflection_mm(rigidity_nm2: f64) -> Result<f64, StiffnessError> {
    const FORCE_N: f64 = 7.27;
    const SPAN_MM: f64 = 200.0;
    // The rigidity falls with one over the deflection.
    Ok(three_point_rigidity_nm2(FORCE_N, SPAN_MM, 1.0)? / rigidity_nm2)
}
