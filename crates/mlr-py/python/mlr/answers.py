"""The types of the answers: written by tools/python/answers.py from docs/schemas, not by hand.

Numbers are in the units that their names end in.
"""

from typing import Literal, TypeAlias, TypedDict

# What can be wrong with a log.
FindingKind: TypeAlias = Literal["frozen", "dead_accelerometer", "dead_gyroscope", "impossible", "interleaved", "held", "angle_unit", "rate_unit", "acceleration_unit", "gravity", "upside_down", "axes", "contradiction", "saturated", "tipped_over"]
# What becomes of a link that is lost.
LostLinks: TypeAlias = Literal["absent", "locked"]
# What decides which morphology is the answer.
Method: TypeAlias = Literal["mlr", "paper"]
# One list of existence numbers per leg, from the body outward.
Morphology: TypeAlias = list[list[int]]
# The value of a parameter.
Reported: TypeAlias = int | list[int] | float
# How the morphologies are searched.
Search: TypeAlias = Literal["ga", "exact", "atlas"]
# How bad a finding is.
Severity: TypeAlias = Literal["useless", "worse", "note"]


class Alternative(TypedDict):
    """A morphology that explains the recording less well."""

    # Its F on the nominal model.
    cost_rad: float
    # Probability that its lost links are locked and not gone, where that is asked.
    locked_probability: float | None
    # The morphology.
    morphology: Morphology
    # Its probability.
    probability: float


class Harmonic(TypedDict):
    """A part of the residual at a multiple of the gait's frequency."""

    # Its amplitude.
    amplitude_deg: float
    # Its frequency.
    frequency_hz: float
    # Gait phase of its crest, as a share of its own period.
    phase: float


class BestFit(TypedDict):
    """The model and the alignment under which the best morphology is likeliest."""

    # Duration of the robot's gait over the nominal one, less one: its clock's error.
    clock: float
    # How much later than the model the robot moves.
    delay_s: float
    # Root mean square of what is left of roll, pitch and yaw without their means and trends.
    error_deg: list[float]
    # Friction of the ground over the nominal one.
    friction: float
    # Log time at which the model's walk starts that fits best, in steps of the alignment: it
    # tells the phase of the gait where the recording does not show the start of the walk.
    gait_start_s: float | None
    # What the lost links are taken to be.
    lost_links: LostLinks
    # Root mean square of measured roll, pitch and yaw without their means and trends.
    motion_deg: list[float]
    # Mass of a payload over that of the body.
    payload: float
    # Where it sits: x and y over half the body's length and width.
    payload_at: list[float]
    # Slope of the ground.
    slope_deg: float
    # Stiffness of the servos over the nominal one.
    stiffness: float
    # Where it rises, counter-clockwise from the robot's first heading.
    uphill_deg: float


class MeasuredReport(TypedDict):
    """What was measured of the robot on a bench, in the unit of the description."""

    # Standard deviation of the measurement.
    deviation: float
    # Name of the parameter.
    name: str
    # Its value.
    value: float


class ParameterReport(TypedDict):
    """One parameter of the robot, in its coordinate."""

    # As the description had it.
    described: float
    # Its standard deviation.
    deviation: float
    # With which the model walks most like the robot.
    fitted: float
    # Whether the walks tell it: more than the make does.
    is_told: bool
    # Standard deviation among robots of the make.
    make_deviation: float
    # Its name.
    name: str
    # The robot's own, most probable.
    physical: float
    # Standard deviation of the robot's own after each of the walks.
    physical_deviations: list[float]
    # What the numbers are in: `ln` for the logarithm of a positive number.
    unit: str


class Course(TypedDict):
    """One run of the genetic algorithm."""

    # The best cost so far in degrees, generation by generation.
    cost_per_generation: list[float]
    # Its result.
    morphology: Morphology


class RemainingResidual(TypedDict):
    """The most striking thing about what remains."""

    # Its amplitude.
    amplitude_deg: float | None
    # Axis on which most remains, compared with what usually does.
    axis: str
    # Torque about that axis which would swing the free body so.
    body_torque_nm: float | None
    # What it looks like.
    explains: str
    # Frequency of the strongest oscillation there.
    frequency_hz: float | None
    # Whether it repeats with the gait.
    locked_to_gait: bool
    # Root mean square of what remains there without offset and trend.
    remaining_deg: float
    # What is usual there.
    usual_deg: float


class StretchErrors(TypedDict):
    """Root mean square errors, degrees."""

    # Roll, pitch, yaw on the fitted stretch.
    fit_axes_deg: list[float]
    # Over all axes, on the stretch that parameters were fitted on.
    fit_deg: float
    # Roll, pitch, yaw on the unseen stretch.
    validation_axes_deg: list[float]
    # Over all axes, on the stretch that they never saw.
    validation_deg: float


class StretchesS(TypedDict):
    """Log times of stretches, from and to."""

    # What hypotheses are judged and parameters fitted by.
    fit: list[float]
    # What nothing has seen.
    validation: list[float]


class WalkCandidate(TypedDict):
    """An effect that was not added, and why."""

    # Name of the effect.
    kind: str
    # Its parameters as fitted; empty where it was not tried.
    parameters: dict[str, Reported]
    # Probability of its kind to be in the robot.
    probability: float | None
    # Error on the unseen stretch with it.
    validation_deg: float | None
    # What was decided.
    verdict: str


class _Finding(TypedDict):
    # Log time at which it begins.
    from_s: float
    # What.
    kind: FindingKind
    # What was seen, in words.
    reason: str
    # How bad it is.
    severity: Severity
    # Log time at which it ends.
    to_s: float


class Finding(_Finding, total=False):
    """Something that is wrong with a log."""

    # What to type or to do about it, where that is known.
    cure: str | None


class Frequency(TypedDict):
    """How often repeated runs of the genetic algorithm gave a morphology."""

    # Its deciding cost.
    cost_deg: float
    # Runs that ended with it.
    count: int
    # The morphology.
    morphology: Morphology


class Rival(TypedDict):
    """An effect with its parameters."""

    # Name of the effect.
    kind: str
    # Its parameters as fitted.
    parameters: dict[str, Reported]


class Simulation(TypedDict):
    """What is said about a simulated log: the object that other programs read."""

    # Numbered from 1.
    damaged_legs: list[int]
    # The file of joint angles, if one was asked for.
    joints: str | None
    # The file of the log; empty where it went to none.
    log: str
    # The robot that walked.
    morphology: Morphology
    # Log time at which the walk starts.
    motion_start_s: float
    # Samples of the log.
    samples: int
    schema: Literal["mlr.simulation/1"]


class AxisResidual(TypedDict):
    """One axis of what a model leaves of a walk."""

    # Straight trend while it walks.
    drift_dps: float
    # The part of that which is faster than about three hertz: no walking body swings so out of
    # step with its gait.
    fast_deg: float
    # Mean while the legs of the gait's first half cycle swing, less that of the second half: what
    # one group of legs does and the other does not.
    group_deg: float
    # What repeats with the gait: its fundamental and harmonics.
    harmonics: list[Harmonic]
    # Probability that independent errors change sign as rarely or as often (Wald and Wolfowitz).
    independence_p_value: float
    # Its amplitude.
    irregular_amplitude_deg: float | None
    # Root mean square of what is left of all this.
    irregular_deg: float
    # Strongest oscillation of what is left.
    irregular_hz: float | None
    # Mean while the robot stands, if the log shows it.
    standing_deg: float | None
    # Mean while it walks.
    walking_deg: float
    # Probability that white noise is as correlated as what is left (Ljung and Box).
    whiteness_p_value: float
    # Slope over the sine of the heading, for a robot that turns.
    with_heading_deg: float | None


class WalkReport(TypedDict):
    """What one walk added."""

    # What belongs to its day, in standard deviations of the prior.
    day: dict[str, float]
    # Errors of the robot as calibrated.
    error_after: StretchErrors
    # Errors of the robot as it was known before.
    error_before: StretchErrors
    # Name of the gait.
    gait: str
    # The log: a file, or a port.
    log: str
    # SHA-256 of its bytes, hexadecimal; empty where it is no file.
    sha256: str
    # Share of healthy robots that differ as much from what was known of this one before.
    tail_probability: float


class _LogQuality(TypedDict):
    # What is wrong, the worst first.
    findings: list[Finding]
    # Rows per second.
    sample_rate_hz: float
    # How often a second the values change: the rate of the sensor itself.
    value_rate_hz: float


class LogQuality(_LogQuality, total=False):
    """What a log says about itself, before anybody asks what the robot did."""

    # Length of the mean specific force, of the standing robot where the log shows it.
    gravity_mps2: float | None


class TracedEffect(TypedDict):
    """An effect that was added to the model."""

    # Parameters that lie at the bound of what is tried.
    at_bound: list[str]
    # What it changes, in words.
    explains: str
    # 95 % interval of each parameter that the log determines.
    interval_95: dict[str, list[float]]
    # Name of the effect.
    kind: str
    # Value of each parameter; the name ends in the unit.
    parameters: dict[str, Reported]
    # Probability of its kind to be in the robot.
    probability: float
    # Effects of other sets that together with this one hold 90 % of the probability.
    rivals: list[Rival]
    # Parameters that the log does not determine.
    undetermined: list[str]


class WalkAlternative(TypedDict):
    """A hypothesis with its probability."""

    # The effects.
    effects: list[Rival]
    # Whether the lost ones hang on.
    locked_links: bool
    # Which links are left.
    morphology: Morphology
    # How probable all of this is.
    probability: float
    # Whether something that no effect of the library makes is there as well.
    unknown: bool


class ByAxis(TypedDict):
    """Something for each axis, by its name."""

    # About y.
    pitch: AxisResidual
    # About x.
    roll: AxisResidual
    # About z.
    yaw: AxisResidual


class Calibration(TypedDict):
    """A calibration with all that is needed to judge it."""

    # Covariance of the parameters' coordinates in the description: the lower triangle, row by
    # row.
    covariance: list[list[float]]
    # What was measured on a bench, beside the walks.
    measured: list[MeasuredReport]
    # The robot's parameters.
    parameters: list[ParameterReport]
    # The same of the robot's own parameters.
    physical_covariance: list[list[float]]
    # Name and version of the program.
    program: str
    schema: Literal["mlr.calibration/1"]
    # The walks, in their order.
    walks: list[WalkReport]
    # What else to know.
    warnings: list[str]


class Detection(TypedDict):
    """The answer with where it comes from: the object that other programs read."""

    # Log time at which damage was flagged first, if it was.
    damage_s: float | None
    # Whether damage was flagged.
    flagged: bool
    # Where the recording came from: a file, or a port.
    log: str
    # Quality of the recording.
    log_quality: LogQuality
    # Largest fluctuation of roll or pitch within a window.
    max_fluctuation_deg: float
    # Log time at which the walk started, if the recording shows it.
    motion_start_s: float | None
    schema: Literal["mlr.detection/1"]
    # Fluctuation that a healthy robot stays below.
    threshold_deg: float
    # Warnings for people.
    warnings: list[str]


class LogReport(TypedDict):
    """One of several recordings, with where it came from."""

    # The paper's F of the best morphology on the nominal model.
    cost_rad: float
    # The file.
    file: str
    # How the walk of the best morphology fits best.
    fit: BestFit
    # The gait that the robot walked.
    gait: str
    # Quality of the recording.
    log_quality: LogQuality
    # F per sample and axis.
    mean_error_deg: float
    # Log time at which the walk started, if the recording shows it.
    motion_start_s: float | None
    # Probability, by this log alone, that something else than damage to legs decides how the
    # robot walks.
    something_else_probability: float | None
    # Warnings for people.
    warnings: list[str]
    # Length of the compared stretch.
    window_s: float
    # Log time at which the compared stretch begins.
    window_start_s: float


class Explanation(TypedDict):
    """An explanation with all that is needed to get it again: the object that other programs read."""

    # The most probable hypotheses.
    alternatives: list[WalkAlternative]
    # Log times of the walk before damage in mid-walk that the robot is known by.
    calibrated_on_s: list[float] | None
    # Kinds that are not among the effects, the most probable first.
    candidates: list[WalkCandidate]
    # Numbers (from 1) of the legs that miss a link.
    damaged_legs: list[int]
    # Probability of each kind of effect to be in the robot; `none`: that nothing is wrong with it
    # but that links are gone; `unknown`: that something is that no effect of the library makes.
    effect_probability: dict[str, float]
    # The most probable set of effects; empty where the model lacks nothing.
    effects: list[TracedEffect]
    # Time that it took.
    elapsed_s: float
    # Error with all effects.
    error_after: StretchErrors
    # Error of the robot as described: only the zeros of time and heading are fitted.
    error_before: StretchErrors
    # Error with the nuisance parameters fitted, without effects.
    error_calibrated: StretchErrors
    # Where the recording came from: a file, or a port.
    log: str
    # What the recording says about itself.
    log_quality: LogQuality
    # The same with all effects in place.
    morphology: Morphology
    # The morphology as identified at first.
    morphology_before: Morphology
    # Error that sensor noise and the model's own shortcomings leave.
    noise_floor_deg: float
    # Nuisance parameters as fitted, in standard deviations of their priors.
    nuisance: dict[str, float]
    # What remains.
    residual: RemainingResidual
    # The same with all effects.
    residual_after: ByAxis
    # The residual of the most probable robot without effects, its nuisance parameters fitted,
    # split into what physics tells apart.
    residual_before: ByAxis
    # Name and version of the form.
    schema: Literal["mlr.explanation/1"]
    # Seed of the search.
    seed: int
    # Log times of the stretches that errors are measured on.
    stretches_s: StretchesS
    # Whether something that no effect of the library makes is more probable than not.
    unexplained: bool
    # What else to know.
    warnings: list[str]


class _Identification(TypedDict):
    # The next most probable morphologies.
    alternatives: list[Alternative]
    # Best deciding cost so far in degrees, generation by generation, of the genetic algorithm's
    # most frequent result.
    cost_per_generation: list[float]
    # The paper's F of the best morphology on the nominal model.
    cost_rad: float
    # Numbers (from 1) of the legs that miss a link.
    damaged_legs: list[int]
    # The damage in words.
    description: str
    # Simulations that diverged and count as infinitely costly.
    diverged: int
    # Time that it took.
    elapsed_s: float
    # Morphologies evaluated.
    evaluations: int
    # How the walk of the best morphology fits best.
    fit: BestFit
    # The results of repeated runs, most frequent first.
    frequencies: list[Frequency]
    # Whether no morphology explains the recording: it is more probable than not that something
    # else decides how the robot walks.
    implausible: bool
    # Morphologies that this recording cannot tell from the best: together with it, those that
    # hold nearly all of the probability.
    indistinguishable: list[Morphology]
    # Probability of each leg to miss a link.
    leg_damage_probability: list[float]
    # Probability that exactly these legs are damaged.
    legs_probability: float
    # Probability of each link to be gone, leg by leg from the body outward.
    link_loss_probability: list[list[float]]
    # Probability that the lost links of this morphology are locked and not gone; `None` where it
    # lost none, and by the paper's method.
    locked_probability: float | None
    # Where the recording came from: a file, or a port.
    log: str
    # Quality of the recording.
    log_quality: LogQuality
    # F per sample and axis.
    mean_error_deg: float
    # What decided.
    method: Method
    # The best morphology.
    morphology: Morphology
    # Log time at which the walk started, if the recording shows it.
    motion_start_s: float | None
    # Probability of exactly this morphology.
    probability: float
    # The repeated runs one by one.
    runs: list[Course]
    # Name and version of the form.
    schema: Literal["mlr.identification/1"]
    # How the morphologies were searched.
    search: Search
    # Seed of the search.
    seed: int
    # Probability that something else than damage to legs decides how the robot walks.
    something_else_probability: float | None
    # Warnings for people.
    warnings: list[str]
    # Length of the compared stretch.
    window_s: float
    # Log time at which the compared stretch begins.
    window_start_s: float


class Identification(_Identification, total=False):
    """An answer with all that is needed to get it again: the object that other programs read."""

    # Of several recordings each.
    logs: list[LogReport]
