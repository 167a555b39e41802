//! Orientation of the body from the samples of its sensor.

use mlr_filter::{Axes, unwrapped_rad};
use mlr_imu::{CALIBRATION_S, Fusion, ImuSample};
use nalgebra::Vector3;

/// Roll, pitch and unwrapped yaw of the body at a time counted from the first
/// sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Time since the first sample.
    pub time_s: f64,
    /// The angles in radians.
    pub angles_rad: Axes<f64>,
}

/// Fuses samples to orientation, unless the device does, with the bias that the gyroscope
/// has while the robot stands.
pub(crate) struct AttitudeEstimator {
    orientation: Orientation,
    bias: Bias,
}

/// The gyroscope's bias, in the body's axes.
#[derive(Debug, Clone, Copy, Default)]
struct Bias {
    /// From an earlier run.
    remembered_radps: Option<Vector3<f64>>,
    /// From this run, with the sensor at rest, and when.
    found: Option<(f64, Vector3<f64>)>,
}

impl Bias {
    fn best_radps(&self) -> Vector3<f64> {
        let found_radps = self.found.map(|(_, bias_radps)| bias_radps);
        found_radps.or(self.remembered_radps).unwrap_or_default()
    }
}

/// Orientation so far. The gyroscope's bias is taken while the robot stands,
/// before fusion starts.
enum Orientation {
    Calibrating {
        rates_radps: Vec<Vector3<f64>>,
        begin_s: f64,
    },
    Fused {
        fusion: Box<Fusion>,
        last_s: f64,
        yaw_offset_rad: f64,
        last_yaw_rad: f64,
    },
    /// The device's own.
    Given { last_yaw_rad: f64 },
}

impl Orientation {
    /// Nothing is known.
    fn unknown() -> Self {
        Self::Calibrating {
            rates_radps: Vec::new(),
            begin_s: 0.0,
        }
    }
}

/// Step that fusion expects; each sample is taken with its own.
const NOMINAL_STEP_S: f64 = 0.001;
/// After a pause of this length fusion starts anew.
const PAUSE_S: f64 = 1.0;

impl AttitudeEstimator {
    /// An estimator for a gyroscope that had this bias, in the body's axes, when it last
    /// stood.
    pub(crate) fn new(bias_radps: Option<Vector3<f64>>) -> Self {
        Self {
            orientation: Orientation::unknown(),
            bias: Bias {
                remembered_radps: bias_radps,
                found: None,
            },
        }
    }

    /// Bias of the gyroscope, if the sensor was seen at rest in this run.
    pub(crate) fn bias_radps(&self) -> Option<Vector3<f64>> {
        self.bias.found.map(|(_, bias_radps)| bias_radps)
    }

    /// Drops a bias found after `since_s`: that of a faulty sensor.
    pub(crate) fn doubt_bias(&mut self, since_s: f64) {
        self.bias.found = self.bias.found.filter(|(time_s, _)| *time_s <= since_s);
    }

    /// Forgets what was fused of faulty samples, except for yaw.
    pub(crate) fn restart(&mut self, time_s: f64) {
        match self.orientation {
            Orientation::Fused { last_yaw_rad, .. } if self.bias.found.is_some() => {
                let yaw_rad = if last_yaw_rad.is_finite() {
                    last_yaw_rad
                } else {
                    0.0
                };
                self.orientation = self.fusion_from(time_s, yaw_rad);
            }
            Orientation::Given { .. } => {}
            _ => self.orientation = Orientation::unknown(),
        }
    }

    /// The attitude with the next sample, in the body's axes; `None` while the gyroscope's
    /// bias is measured, and where fusion starts. The bias of a `faulty` sensor is not
    /// taken.
    pub(crate) fn update(
        &mut self,
        time_s: f64,
        sample: &ImuSample,
        faulty: bool,
    ) -> Option<Attitude> {
        if let Some(orientation) = sample.orientation {
            let (roll, pitch, yaw) = orientation.euler_angles();
            let yaw = match self.orientation {
                Orientation::Given { last_yaw_rad } => unwrapped_rad(last_yaw_rad, yaw),
                _ => yaw,
            };
            self.orientation = Orientation::Given { last_yaw_rad: yaw };
            let angles_rad = Axes { roll, pitch, yaw };
            return Some(Attitude { time_s, angles_rad });
        }
        let (acceleration, rate) = (sample.acceleration_mps2?, sample.angular_rate_radps?);
        match &mut self.orientation {
            Orientation::Calibrating {
                rates_radps,
                begin_s,
            } => {
                if rates_radps.is_empty() {
                    *begin_s = time_s;
                }
                rates_radps.push(rate);
                if time_s - *begin_s >= CALIBRATION_S {
                    if !faulty {
                        let bias_radps = mlr_imu::rest_bias_radps(rates_radps);
                        self.bias.found = bias_radps.map(|bias_radps| (time_s, bias_radps));
                    }
                    self.orientation = self.fusion_from(time_s, 0.0);
                }
                None
            }
            Orientation::Given { last_yaw_rad } => {
                let yaw_rad = *last_yaw_rad;
                self.orientation = self.fusion_from(time_s, yaw_rad);
                None
            }
            Orientation::Fused {
                fusion,
                last_s,
                yaw_offset_rad,
                last_yaw_rad,
            } => {
                let pause_s = time_s - std::mem::replace(last_s, time_s);
                if pause_s > PAUSE_S {
                    let yaw_rad = *last_yaw_rad;
                    self.orientation = self.fusion_from(time_s, yaw_rad);
                    return None;
                }
                let mut angles_rad = fusion.update(time_s, &acceleration, &rate);
                angles_rad.yaw += *yaw_offset_rad;
                *last_yaw_rad = angles_rad.yaw;
                Some(Attitude { time_s, angles_rad })
            }
        }
    }

    /// Fusion that starts now, with yaw where it was last seen.
    fn fusion_from(&self, now_s: f64, yaw_rad: f64) -> Orientation {
        Orientation::Fused {
            fusion: Box::new(Fusion::new(NOMINAL_STEP_S, self.bias.best_radps())),
            last_s: now_s,
            yaw_offset_rad: yaw_rad,
            last_yaw_rad: yaw_rad,
        }
    }
}
