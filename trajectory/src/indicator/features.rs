//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! Indicators of features of a posture, instead of its joints.
//!
//! The kernel of Eq. 4.14 (C. Dai, *Material Deposition in 3D Space*, dissertation, TU Delft 2020) is as wide in every
//! direction of joint space: 1.2 rad. A nozzle that leaves the surface downwards touches the layer below after a few
//! thousandths of a radian, which such kernels cannot resolve from thousands of samples. A kernel over what the forward kinematics says can: N. Das,
//! M. Yip, *Forward kinematics kernel for improved proxy collision checking*, IEEE Robotics and Automation Letters 5(2),
//! 2020, take points on the links. [`TurnsAndGap`] takes the one length that the sampling of section 4.4.2 knows anyway,
//! the gap between tip and working surface, and joints as points on circles, since a whole turn changes nothing.
//!
//! A machine learns from [`features_of`] samples as from any; [`OnFeatures`] makes it an indicator of joints.

use super::CollisionIndicator;
use super::contact::ContactSpace;
use super::samples::Sample;

/// `D` numbers that describe a posture of `N` joints.
pub trait Features<const N: usize, const D: usize>: Sync {
    /// The features.
    fn features(&self, joints: &[f64; N]) -> [f64; D];

    /// The features, and for each joint their derivatives by it.
    fn slopes(&self, joints: &[f64; N]) -> ([f64; D], [[f64; D]; N]);
}

/// The same samples, with features in place of joints.
pub fn features_of<const N: usize, const D: usize>(
    features: &(impl Features<N, D> + ?Sized),
    samples: &[Sample<N>],
) -> Vec<Sample<D>> {
    let sample = |sample: &Sample<N>| Sample { joints: features.features(&sample.joints), collides: sample.collides };
    samples.iter().map(sample).collect()
}

/// An indicator of features as one of joints.
/// ```
/// use curvlay_trajectory::indicator::{CollisionIndicator, Features, IndicatorFn, OnFeatures};
/// // The height of a tip on an arm of two links, each 1 long; it collides below 0.5.
/// struct Height;
/// impl Features<2, 1> for Height {
///     fn features(&self, q: &[f64; 2]) -> [f64; 1] {
///         [q[0].sin() + (q[0] + q[1]).sin()]
///     }
///     fn slopes(&self, q: &[f64; 2]) -> ([f64; 1], [[f64; 1]; 2]) {
///         let outer = (q[0] + q[1]).cos();
///         (self.features(q), [[q[0].cos() + outer], [outer]])
///     }
/// }
/// let low = IndicatorFn { value: |z: &[f64; 1]| 0.5 - z[0], gradient: |z: &[f64; 1]| (0.5 - z[0], [-1.0]) };
/// let indicator = OnFeatures::new(low, Height);
/// assert!(indicator.predicts(&[0.1, 0.1]) && !indicator.predicts(&[1.0, 0.0]));
/// assert_eq!(indicator.gradient(&[0.0, 0.0]), (0.5, [-2.0, -1.0]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct OnFeatures<I, F, const D: usize> {
    indicator: I,
    features: F,
}

impl<I, F, const D: usize> OnFeatures<I, F, D> {
    /// An indicator over features.
    pub fn new(indicator: I, features: F) -> Self {
        OnFeatures { indicator, features }
    }

    /// The indicator of features.
    pub fn inner(&self) -> &I {
        &self.indicator
    }
}

impl<const N: usize, const D: usize, I, F> CollisionIndicator<N> for OnFeatures<I, F, D>
where
    I: CollisionIndicator<D>,
    F: Features<N, D>,
{
    fn value(&self, joints: &[f64; N]) -> f64 {
        self.indicator.value(&self.features.features(joints))
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        let (features, slopes) = self.features.slopes(joints);
        let (value, gradient) = self.indicator.gradient(&features);
        (value, slopes.map(|slope| slope.iter().zip(&gradient).map(|(a, b)| a * b).sum()))
    }
}

/// Cosine and sine of each joint, then the gap `g` between tip and working surface as `height * g / sqrt(g^2 + near^2)`:
/// `2 N + 1` features.
///
/// Far from the surface the last one hardly changes any more, so that a layer below differs from what is deeper without
/// kernels that are all alone.
#[derive(Clone, Copy, Debug)]
pub struct TurnsAndGap<S> {
    /// Knows the gap.
    pub space: S,
    /// The value of the last feature far above the surface; below it the same with a minus.
    pub height: f64,
    /// The gap at which the last feature has 0.7 of `height`, in millimetres: about a layer.
    pub near_mm: f64,
}

impl<S> TurnsAndGap<S> {
    /// The last feature and its derivative by the gap.
    fn bent(&self, gap: f64) -> (f64, f64) {
        let long = gap.hypot(self.near_mm);
        (self.height * gap / long, self.height * self.near_mm * self.near_mm / (long * long * long))
    }

    fn all<const N: usize, const D: usize>(joints: &[f64; N], last: f64) -> [f64; D] {
        const { assert!(D == 2 * N + 1, "TurnsAndGap has 2 N + 1 features") };
        let mut features = [last; D];
        for (pair, angle) in features.chunks_exact_mut(2).zip(joints) {
            pair.copy_from_slice(&[angle.cos(), angle.sin()]);
        }
        features
    }
}

impl<const N: usize, const D: usize, S: ContactSpace<N>> Features<N, D> for TurnsAndGap<S> {
    fn features(&self, joints: &[f64; N]) -> [f64; D] {
        Self::all(joints, self.bent(self.space.gap(joints)).0)
    }

    fn slopes(&self, joints: &[f64; N]) -> ([f64; D], [[f64; D]; N]) {
        let (gap, gradient) = self.space.gap_gradient(joints);
        let (last, slope) = self.bent(gap);
        let of_joint = |j: usize| {
            let mut slopes = [0.0; D];
            (slopes[2 * j], slopes[2 * j + 1]) = (-joints[j].sin(), joints[j].cos());
            slopes[D - 1] = slope * gradient[j];
            slopes
        };
        (Self::all(joints, last), std::array::from_fn(of_joint))
    }
}
