//! Time to condition one window of 5 s, at the rate of a recording and of a
//! simulation.
//!
//! ```text
//! cargo bench -p mlr-filter
//! ```

use std::f64::consts::TAU;

use mlr_filter::{
    Axes, FilterSettings, FourierFilter, MotionSettings, MotionStart, OrientationSeries,
    SamplingLimits, Window,
};

fn main() {
    divan::main();
}

const WINDOW: Window = Window {
    start_s: 2.0,
    duration_s: 5.0,
};

/// A robot that stands for two seconds and then rocks.
fn recording(rate_hz: u32) -> OrientationSeries {
    let times_s: Vec<f64> = (0..10 * rate_hz)
        .map(|i| f64::from(i) / f64::from(rate_hz))
        .collect();
    let rocking: Vec<f64> = times_s
        .iter()
        .map(|t| 0.1 * ((t - 2.0).max(0.0) * TAU).sin())
        .collect();
    OrientationSeries::new(times_s, Axes::from_fn(|_| rocking.clone()))
        .expect("all columns have one length")
}

#[divan::bench(args = [100, 970])]
fn cut_and_condition(bencher: divan::Bencher<'_, '_>, rate_hz: u32) {
    let recording = recording(rate_hz);
    let mut filter = FourierFilter::new(FilterSettings::default(), WINDOW.duration_s)
        .expect("the defaults are valid");
    bencher.bench_local(|| {
        let even = WINDOW
            .cut(&recording, &SamplingLimits::default())
            .expect("the recording covers the window");
        filter.condition(&even)
    });
}

#[divan::bench]
fn find_motion_start(bencher: divan::Bencher<'_, '_>) {
    let recording = recording(970);
    bencher.bench(|| MotionStart::find(&recording, &MotionSettings::default()));
}
