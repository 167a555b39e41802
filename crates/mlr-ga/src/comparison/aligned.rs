use std::borrow::Cow;

use mlr_filter::{MovingMean, OrientationSeries};
use serde::{Deserialize, Serialize};

use super::{
    ComparableWalk, LikelihoodSettings, Misfit,
    spectral_form::{SpectralForm, SpectralSettings},
};

/// How a robot's walk is laid over the model's.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Alignment {
    /// Duration of the robot's gait over the nominal one, less one: its clock's
    /// error.
    pub clock: f64,
    /// How much later than the model the robot moves.
    pub delay_s: f64,
}

/// The alignments that are tried. The clock of a servo controller is off by
/// several percent at worst, and a command needs up to a tenth of a second longer
/// than in the nominal model.
const CLOCKS: std::ops::RangeInclusive<i32> = -8..=8;
const CLOCK_STEP: f64 = 0.01;
const DELAYS: std::ops::RangeInclusive<i32> = -1..=6;
const DELAY_STEP_S: f64 = 0.02;
/// Axes of a sample.
const AXES: usize = 3;

impl Alignment {
    /// Every alignment that is tried.
    pub fn all() -> impl Iterator<Item = Self> {
        CLOCKS.flat_map(|clock| {
            DELAYS.map(move |delay| Self {
                clock: f64::from(clock) * CLOCK_STEP,
                delay_s: f64::from(delay) * DELAY_STEP_S,
            })
        })
    }

    /// When the robot does what the model does `gait_time_s` after the start of
    /// the compared stretch, counted from the same.
    pub(crate) fn robot_time_s(&self, gait_time_s: f64) -> f64 {
        gait_time_s * (1.0 + self.clock) + self.delay_s
    }

    /// The inverse: gait time since the same at which the model does what the robot does then.
    pub(crate) fn gait_time_s(&self, robot_time_s: f64) -> f64 {
        (robot_time_s - self.delay_s) / (1.0 + self.clock)
    }

    /// A simulated walk as this robot walks it, where both are compared from gait time `start_s` on.
    pub(crate) fn of_walk<'a>(
        &self,
        walk: &'a OrientationSeries,
        start_s: f64,
    ) -> Cow<'a, OrientationSeries> {
        if *self == Self::default() {
            return Cow::Borrowed(walk);
        }
        let times_s = walk.times_s().iter();
        let mut times_s: Vec<f64> = times_s
            .map(|t| start_s + self.robot_time_s(t - start_s))
            .collect();
        let mut angles_rad = walk.angles_rad().clone();
        // Who moves later stands longer.
        if times_s.first().is_some_and(|first| *first > start_s) {
            times_s.insert(0, start_s);
            for axis in [
                &mut angles_rad.roll,
                &mut angles_rad.pitch,
                &mut angles_rad.yaw,
            ] {
                axis.insert(0, axis[0]);
            }
        }
        let aligned = OrientationSeries::new(times_s, angles_rad);
        Cow::Owned(aligned.expect("time stamps and angles stay finite and as many"))
    }

    /// Time that the slowest robot needs for `duration_s` of the gait.
    pub fn longest_s(duration_s: f64) -> f64 {
        let slowest = Self {
            clock: f64::from(*CLOCKS.end()) * CLOCK_STEP,
            delay_s: f64::from(*DELAYS.end()) * DELAY_STEP_S,
        };
        slowest.robot_time_s(duration_s) + ComparableWalk::HALF_WIDTH_S
    }
}

/// A stretch of a recording, sampled for every alignment: the spectra of its angles below the
/// filter's cutoff, each axis without its mean and trend.
#[derive(Debug, Clone)]
pub struct AlignedMeasurement {
    alignments: Vec<Alignment>,
    /// For each alignment roll, pitch and yaw one after the other, in degrees.
    spectra: Vec<f32>,
    form: SpectralForm,
}

impl AlignedMeasurement {
    /// Samples the stretch that begins at `start_s` of the recording's time, whose
    /// stamps increase. `samples` of [`ComparableWalk::RATE_HZ`] are compared.
    pub fn new(
        recording: &OrientationSeries,
        start_s: f64,
        samples: usize,
        spectral: SpectralSettings,
    ) -> Self {
        let means = MovingMean::new(recording);
        let form = SpectralForm::new(samples, spectral);
        let alignments: Vec<Alignment> = Alignment::all().collect();
        let mut spectra = vec![0.0; alignments.len() * AXES * form.axis_len()];
        let mut signals = vec![0.0; AXES * samples];
        for (alignment, spectra) in alignments
            .iter()
            .zip(spectra.chunks_mut(AXES * form.axis_len()))
        {
            for index in 0..samples {
                let gait_time_s = index as f64 / ComparableWalk::RATE_HZ;
                let time_s = start_s + alignment.robot_time_s(gait_time_s);
                let mean = means.around(time_s, ComparableWalk::HALF_WIDTH_S);
                for (axis, angle_rad) in mean.into_array().into_iter().enumerate() {
                    signals[axis * samples + index] = angle_rad.to_degrees() as f32;
                }
            }
            let axes = signals.chunks_mut(samples);
            for (signal, spectrum) in axes.zip(spectra.chunks_mut(form.axis_len())) {
                form.transform(signal, spectrum);
            }
        }
        Self {
            alignments,
            spectra,
            form,
        }
    }

    /// Samples that are compared.
    pub fn samples(&self) -> usize {
        self.form.samples()
    }

    /// How far the body moves: mean square of each axis without its mean and trend, in deg²,
    /// under an alignment that is tried.
    pub fn motion_deg2(&self, alignment: Alignment) -> [f64; AXES] {
        let still = vec![0.0; AXES * self.form.axis_len()];
        self.plain_deg2(alignment, &still)
    }

    /// How far `walk`, from its sample `from` on, is from the measurement: mean square of each
    /// axis without its mean and trend, in deg², every frequency below the cutoff alike.
    /// `None` when the walk is too short.
    pub fn error_deg2(
        &self,
        walk: &ComparableWalk,
        from: usize,
        alignment: Alignment,
    ) -> Option<[f64; AXES]> {
        Some(self.plain_deg2(alignment, &self.simulated(walk, from)?))
    }

    fn plain_deg2(&self, alignment: Alignment, simulated: &[f32]) -> [f64; AXES] {
        let index = self.alignments.iter().position(|one| *one == alignment);
        let mut all = self.spectra.chunks(AXES * self.form.axis_len());
        let measured = index.and_then(|index| all.nth(index)).unwrap_or_default();
        let axes = measured
            .chunks(self.form.axis_len().max(1))
            .zip(simulated.chunks(self.form.axis_len().max(1)));
        let mut plain_deg2 = [0.0; AXES];
        for (target, (measured, simulated)) in plain_deg2.iter_mut().zip(axes) {
            *target = self.form.plain_square(measured, simulated);
        }
        plain_deg2
    }

    /// How far `walk`, from its sample `from` on, is from the measurement, with the
    /// alignment under which it is likeliest. `None` when the walk is too short.
    pub fn misfit(
        &self,
        walk: &ComparableWalk,
        from: usize,
        settings: &LikelihoodSettings,
    ) -> Option<Misfit> {
        self.misfits(walk, from)?.max_by(|a, b| {
            settings
                .ln_likelihood(a)
                .total_cmp(&settings.ln_likelihood(b))
        })
    }

    /// What the logarithm of the likelihood can still become of a walk of which this
    /// measurement shows the first `share`. `None` when the walk is too short.
    pub fn ln_bound(
        &self,
        walk: &ComparableWalk,
        from: usize,
        share: f64,
        settings: &LikelihoodSettings,
    ) -> Option<f64> {
        self.misfits(walk, from)?
            .map(|misfit| settings.ln_bound(&misfit, share))
            .max_by(f64::total_cmp)
    }

    /// The misfit under each alignment.
    fn misfits(&self, walk: &ComparableWalk, from: usize) -> Option<impl Iterator<Item = Misfit>> {
        let length = self.form.axis_len();
        let simulated = self.simulated(walk, from)?;
        let measured = self.spectra.chunks(AXES * length);
        Some(
            self.alignments
                .iter()
                .zip(measured)
                .map(move |(alignment, measured)| {
                    let square = |axis: usize| {
                        let range = axis * length..(axis + 1) * length;
                        square_distance(&measured[range.clone()], &simulated[range])
                    };
                    Misfit {
                        mean_square_deg2: [square(0), square(1), square(2)],
                        alignment: *alignment,
                    }
                }),
        )
    }

    /// The spectra of a walk from its sample `from` on.
    fn simulated(&self, walk: &ComparableWalk, from: usize) -> Option<Vec<f32>> {
        let (samples, length) = (self.form.samples(), self.form.axis_len());
        let mut spectra = vec![0.0; AXES * length];
        let angles = walk.angles_deg().as_ref().into_array();
        for (axis, spectrum) in angles.into_iter().zip(spectra.chunks_mut(length)) {
            let mut signal = axis.get(from..from + samples)?.to_vec();
            self.form.transform(&mut signal, spectrum);
        }
        Some(spectra)
    }
}

fn square_distance(a: &[f32], b: &[f32]) -> f64 {
    // Eight sums side by side let the compiler use whole registers; the order of
    // the additions is fixed, so that the result is the same everywhere.
    const LANES: usize = 8;
    let mut sums = [0.0_f32; LANES];
    let (a_lanes, b_lanes) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f32 = a_lanes
        .remainder()
        .iter()
        .zip(b_lanes.remainder())
        .map(|(x, y)| (x - y) * (x - y))
        .sum();
    for (x, y) in a_lanes.zip(b_lanes) {
        for lane in 0..LANES {
            let difference = x[lane] - y[lane];
            sums[lane] += difference * difference;
        }
    }
    f64::from(sums.iter().sum::<f32>() + rest)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use mlr_filter::Axes;
    use proptest::prelude::*;

    use super::*;

    const SPECTRAL: SpectralSettings = SpectralSettings {
        cutoff_hz: 10.0,
        gait_period_s: 1.0,
        between_harmonics: 0.36,
    };

    /// Angles of a gait with a period of one second, in radians.
    fn gait(t: f64) -> Axes<f64> {
        let walked = t.max(0.0);
        Axes {
            roll: 0.1 * (TAU * walked).sin(),
            pitch: 0.05 * (2.0 * TAU * walked).sin().powi(2),
            yaw: 0.08 * walked + 0.03 * (TAU * walked).cos(),
        }
    }

    fn series(from_s: f64, to_s: f64, f: impl Fn(f64) -> Axes<f64>) -> OrientationSeries {
        let times_s: Vec<f64> = (0..((to_s - from_s) * 200.0) as u32)
            .map(|i| from_s + f64::from(i) / 200.0)
            .collect();
        let mut angles_rad = Axes::<Vec<f64>>::default();
        for t in &times_s {
            angles_rad.push(f(*t));
        }
        OrientationSeries::new(times_s, angles_rad).unwrap()
    }

    fn simulated() -> ComparableWalk {
        ComparableWalk::new(&series(0.0, 6.0, gait))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn tilt_drift_delay_and_clock_are_forgiven_and_found(
            tilt_rad in prop::array::uniform3(-0.1..0.1_f64),
            drift_radps in -0.05..0.05_f64,
            clock in prop::sample::select(vec![-0.05, 0.0, 0.03]),
            delay_s in prop::sample::select(vec![0.0, 0.04, 0.1]),
        ) {
            let start_s = 2.0;
            let recording = series(0.0, 9.0, |t| {
                let angles = gait((t - start_s - delay_s) / (1.0 + clock));
                Axes {
                    roll: angles.roll + tilt_rad[0],
                    pitch: angles.pitch + tilt_rad[1],
                    yaw: angles.yaw + tilt_rad[2] + drift_radps * t,
                }
            });
            let measured = AlignedMeasurement::new(&recording, start_s, 125, SPECTRAL);
            let misfit = measured
                .misfit(&simulated(), 0, &LikelihoodSettings::default())
                .unwrap();
            prop_assert!(misfit.mean_square_deg2.iter().all(|s| *s < 0.03), "{misfit:?}");
            prop_assert!((misfit.alignment.clock - clock).abs() < 1e-9, "{misfit:?}");
            prop_assert!((misfit.alignment.delay_s - delay_s).abs() < 1e-9, "{misfit:?}");
        }
    }

    #[test]
    fn another_walk_does_not_fit() {
        let recording = series(0.0, 9.0, |t| {
            let angles = gait(t - 2.0);
            Axes {
                roll: -angles.pitch,
                pitch: angles.roll,
                yaw: angles.yaw,
            }
        });
        let measured = AlignedMeasurement::new(&recording, 2.0, 125, SPECTRAL);
        let settings = LikelihoodSettings::default();
        let misfit = measured.misfit(&simulated(), 0, &settings).unwrap();
        assert!(misfit.mean_square_deg2[1] > 5.0, "{misfit:?}");
    }

    #[test]
    fn a_walk_that_is_too_short_is_not_compared() {
        let recording = series(0.0, 9.0, |t| gait(t - 2.0));
        let measured = AlignedMeasurement::new(&recording, 2.0, 125, SPECTRAL);
        let settings = LikelihoodSettings::default();
        assert!(measured.misfit(&simulated(), 0, &settings).is_some());
        assert!(measured.misfit(&simulated(), 100, &settings).is_none());
    }
}
