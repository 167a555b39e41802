//! What may be the case with a robot, and how it would walk then.

mod sensitivity;

use mlr_filter::OrientationSeries;
use mlr_model::{Impacts, LostLinks, Morphology};
use nalgebra::{DMatrix, DVector};

use super::{
    Nuisance, NuisancePrior, Observation, Prediction, WalkModel, discrepancy::Compared,
    discrepancy::Spread, observation::Whitening,
};
use crate::walk_effects::{EffectParameter, Place, WalkEffect};

/// A morphology, what became of its lost links, and effects at places.
#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub(crate) morphology: Morphology,
    pub(crate) lost_links: LostLinks,
    pub(crate) effects: Vec<Placement>,
}

impl Hypothesis {
    /// Whether it has no effects.
    pub(crate) fn is_bare(&self) -> bool {
        self.effects.is_empty()
    }

    /// Whether it says the same, whatever the order of its effects.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let has_all = self.effects.iter().all(|one| other.effects.contains(one));
        self.morphology == other.morphology
            && self.lost_links == other.lost_links
            && self.effects.len() == other.effects.len()
            && has_all
    }
}

/// An effect at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    pub(crate) effect: &'static dyn WalkEffect,
    pub(crate) place: Place,
}

impl PartialEq for Placement {
    fn eq(&self, other: &Self) -> bool {
        self.effect.kind() == other.effect.kind() && self.place == other.place
    }
}

/// One parameter of a hypothesis. Its coordinate has a standard normal prior.
#[derive(Debug, Clone)]
enum Coordinate {
    Nuisance(Nuisance),
    /// A nuisance parameter that an effect replaces: it changes nothing. It keeps its place, because
    /// hypotheses on one robot share sensitivities.
    Replaced(Nuisance),
    /// Of effect `effect`, one parameter.
    Effect {
        effect: usize,
        parameter: EffectParameter,
    },
}

impl Coordinate {
    /// The nuisance parameter that it is, or would be without an effect that replaces it.
    fn nuisance(&self) -> Option<&Nuisance> {
        match self {
            Self::Nuisance(nuisance) | Self::Replaced(nuisance) => Some(nuisance),
            Self::Effect { .. } => None,
        }
    }
}

/// A hypothesis with everything needed to predict its walk.
#[derive(Debug, Clone)]
pub(crate) struct Walker<'a> {
    pub(crate) hypothesis: Hypothesis,
    observation: &'a Observation<'a>,
    prior: &'a NuisancePrior,
    nominal: WalkModel,
    coordinates: Vec<Coordinate>,
    /// Makes deviations of the nuisance parameters, in standard deviations of the make, of their
    /// coordinates; `None` where these are the same.
    mixing: Option<DMatrix<f64>>,
}

/// How the robot of a hypothesis walks with these parameters.
#[derive(Debug, Clone)]
pub(crate) struct Walked {
    /// Coordinates of the parameters.
    pub(crate) z: DVector<f64>,
    pub(crate) model: WalkModel,
    pub(crate) body: OrientationSeries,
    pub(crate) prediction: Prediction,
    /// Measured less predicted.
    pub(crate) residual: DVector<f64>,
}

impl<'a> Walker<'a> {
    pub(crate) fn new(
        hypothesis: Hypothesis,
        observation: &'a Observation<'a>,
        prior: &'a NuisancePrior,
        nominal: &WalkModel,
    ) -> Self {
        let mut nominal = nominal.clone();
        nominal.simulation.lost_links = hypothesis.lost_links;
        if observation.record.is_dead_reckoned() {
            nominal.sensing.filter_time_s = f64::INFINITY;
        }
        let nuisances = Nuisance::of(&hypothesis.morphology, observation.record);
        let mixing = prior.mixing(&nuisances, observation.record);
        let effects = hypothesis.effects.iter();
        let replaced: Vec<Nuisance> = effects
            .flat_map(|placed| placed.effect.replaces(placed.place))
            .collect();
        let nuisances = nuisances.into_iter();
        let mut coordinates: Vec<Coordinate> = nuisances
            .map(|nuisance| match replaced.contains(&nuisance) {
                true => Coordinate::Replaced(nuisance),
                false => Coordinate::Nuisance(nuisance),
            })
            .collect();
        for (index, placed) in hypothesis.effects.iter().enumerate() {
            let parameters = placed.effect.parameters(placed.place, &nominal).into_iter();
            coordinates.extend(parameters.map(|parameter| Coordinate::Effect {
                effect: index,
                parameter,
            }));
        }
        Self {
            hypothesis,
            observation,
            prior,
            nominal,
            coordinates,
            mixing,
        }
    }

    /// The robot that parameters deviate from.
    pub(crate) fn nominal(&self) -> &WalkModel {
        &self.nominal
    }

    /// The same robot without effects.
    pub(crate) fn without_effects(&self) -> Self {
        let hypothesis = Hypothesis {
            effects: Vec::new(),
            ..self.hypothesis.clone()
        };
        Self::new(hypothesis, self.observation, self.prior, &self.nominal)
    }

    /// Coordinates of a robot as described, with these values of the effects' parameters.
    pub(crate) fn described(&self, values: &[Vec<f64>]) -> DVector<f64> {
        self.with_values(DVector::zeros(self.dimension()), values)
    }

    pub(crate) fn dimension(&self) -> usize {
        self.coordinates.len()
    }

    /// Number of nuisance parameters, which come first.
    pub(crate) fn nuisances(&self) -> usize {
        let is_of_effect = |c: &&Coordinate| matches!(c, Coordinate::Effect { .. });
        self.dimension() - self.coordinates.iter().filter(is_of_effect).count()
    }

    /// Logarithm of what bounds of parameters add to the density of the coordinates' prior: it is
    /// standard normal without them.
    pub(crate) fn ln_truncation(&self) -> f64 {
        let each = self.coordinates.iter().map(|coordinate| match coordinate {
            Coordinate::Nuisance(_) | Coordinate::Replaced(_) => 0.0,
            Coordinate::Effect { parameter, .. } => parameter.ln_truncation(),
        });
        each.sum()
    }

    /// Moves coordinates inside the bounds of their parameters.
    pub(crate) fn clamp(&self, z: &mut DVector<f64>) {
        for (z, coordinate) in z.iter_mut().zip(&self.coordinates) {
            match coordinate {
                Coordinate::Effect { parameter, .. } => *z = parameter.within_bounds(*z),
                Coordinate::Replaced(_) if self.mixing.is_none() => *z = 0.0,
                Coordinate::Replaced(_) | Coordinate::Nuisance(_) => {}
            }
        }
    }

    /// Indices of parameters that change something, with those of the same parameters of another hypothesis.
    fn same_in(&self, other: &Self) -> impl Iterator<Item = (usize, usize)> {
        let placed = |walker: &Self, effect: usize| walker.hypothesis.effects[effect];
        let is_same = move |own: &Coordinate, others: &Coordinate| match (own, others) {
            (Coordinate::Nuisance(own), Coordinate::Nuisance(others)) => own == others,
            (
                Coordinate::Effect { effect, parameter },
                Coordinate::Effect {
                    effect: of_other,
                    parameter: others,
                },
            ) => placed(self, *effect) == placed(other, *of_other) && parameter.name == others.name,
            _ => false,
        };
        let each = self.coordinates.iter().enumerate();
        each.filter_map(move |(k, own)| {
            let known = other.coordinates.iter().position(|one| is_same(own, one))?;
            Some((k, known))
        })
    }

    /// Deviations of the nuisance parameters, in standard deviations of the make.
    pub(crate) fn deviations(&self, z: &DVector<f64>) -> DVector<f64> {
        let own = z.rows(0, self.nuisances().min(z.len()));
        match &self.mixing {
            Some(mixing) => mixing * own,
            None => own.clone_owned(),
        }
    }

    /// The values of each effect's parameters.
    pub(crate) fn values(&self, z: &DVector<f64>) -> Vec<Vec<f64>> {
        let mut values = vec![Vec::new(); self.hypothesis.effects.len()];
        for (z, coordinate) in z.iter().zip(&self.coordinates) {
            if let Coordinate::Effect { effect, parameter } = coordinate {
                values[*effect].push(parameter.value(*z));
            }
        }
        values
    }

    /// Coordinates with these values of the effects' parameters.
    pub(crate) fn with_values(&self, mut z: DVector<f64>, values: &[Vec<f64>]) -> DVector<f64> {
        let mut values = values.iter().flatten();
        for (z, coordinate) in z.iter_mut().zip(&self.coordinates) {
            if let Coordinate::Effect { parameter, .. } = coordinate
                && let Some(value) = values.next()
            {
                *z = parameter.coordinate(*value);
            }
        }
        z
    }

    /// Coordinates of this hypothesis where its robot's own parameters are those that another hypothesis has found at
    /// `z`: what the other's effects have in place of nuisance parameters is theirs here, what the other's robot does
    /// not have stays as described, and effects of both keep their values. Coordinates of further effects are 0.
    pub(crate) fn with_parameters_of(&self, other: &Self, z: &DVector<f64>) -> DVector<f64> {
        let found = other.deviations(z);
        let (without, with) = (other.without_effects_model(z), other.model(z));
        let (settings, record) = (&other.prior.settings, other.observation.record);
        let of_other = |nuisance: &Nuisance| -> f64 {
            let mut each = other.coordinates.iter().zip(&found);
            let known = each.find(|(one, _)| one.nuisance() == Some(nuisance));
            known.map_or(0.0, |(one, deviation)| match one {
                Coordinate::Replaced(_) => nuisance.z_score(settings, record, &without, &with),
                _ => *deviation,
            })
        };
        let own = self.coordinates.iter().filter_map(Coordinate::nuisance);
        let deviations = DVector::from_iterator(self.nuisances(), own.map(of_other));
        let own = match &self.mixing {
            Some(mixing) => mixing.solve_lower_triangular(&deviations),
            None => None,
        };
        let mut coordinates = own
            .unwrap_or(deviations)
            .resize_vertically(self.dimension(), 0.0);
        for (k, known) in self.same_in(other).filter(|(k, _)| *k >= self.nuisances()) {
            coordinates[k] = z[known];
        }
        self.clamp(&mut coordinates);
        coordinates
    }

    /// The matrix that makes deviations of the nuisance parameters of their coordinates.
    pub(crate) fn mixing(&self) -> DMatrix<f64> {
        let n = self.nuisances();
        self.mixing
            .clone()
            .unwrap_or_else(|| DMatrix::identity(n, n))
    }

    /// The robot as fitted, its effects left out.
    pub(crate) fn without_effects_model(&self, z: &DVector<f64>) -> WalkModel {
        self.robot_with(&self.deviations(z))
    }

    /// The robot whose nuisance parameters deviate like this.
    fn robot_with(&self, deviations: &DVector<f64>) -> WalkModel {
        let mut model = self.nominal.clone();
        let record = self.observation.record;
        for (deviation, coordinate) in deviations.iter().zip(&self.coordinates) {
            if let Coordinate::Nuisance(nuisance) = coordinate {
                nuisance.apply(&self.prior.settings, *deviation, record, &mut model);
            }
        }
        model
    }

    /// The robot with these parameters.
    pub(crate) fn model(&self, z: &DVector<f64>) -> WalkModel {
        self.with_effects(self.without_effects_model(z), z)
    }

    fn with_effects(&self, mut model: WalkModel, z: &DVector<f64>) -> WalkModel {
        let values = self.values(z);
        for (placed, values) in self.hypothesis.effects.iter().zip(&values) {
            placed.effect.apply(placed.place, values, &mut model);
        }
        model
    }

    /// `None` when the walk diverges or a value makes no sense.
    pub(crate) fn walk(&self, z: DVector<f64>) -> Option<Walked> {
        let model = self.model(&z);
        self.walked(z, model)
    }

    /// The same with impacts of one kind.
    pub(crate) fn walk_with_impacts(&self, z: DVector<f64>, impacts: Impacts) -> Option<Walked> {
        let mut model = self.model(&z);
        let contact = model.simulation.contact;
        model.simulation.contact = contact.with_impacts(impacts);
        self.walked(z, model)
    }

    fn walked(&self, z: DVector<f64>, model: WalkModel) -> Option<Walked> {
        let samples = self.observation.samples();
        let record = self.observation.record;
        let body = model
            .walk(&self.hypothesis.morphology, record, samples)
            .ok()??;
        Some(self.seen(z, model, body))
    }

    /// The same where the body is known to walk like this: coordinates of the sensor alone differ.
    pub(crate) fn walk_like(&self, z: DVector<f64>, body: &OrientationSeries) -> Walked {
        let model = self.model(&z);
        self.seen(z, model, body.clone())
    }

    fn seen(&self, z: DVector<f64>, model: WalkModel, body: OrientationSeries) -> Walked {
        let record = self.observation.record;
        let prediction = model.predict(&body, record, self.observation.samples());
        let residual = self.observation.residual(&prediction);
        Walked {
            z,
            model,
            body,
            prediction,
            residual,
        }
    }

    /// How far robots of one make spread in this walk, by its sensitivities to nuisance parameters
    /// of the body.
    pub(crate) fn spread(&self, jacobian: &DMatrix<f64>) -> Spread {
        let of_body = (0..self.nuisances()).filter(|k| !self.is_of_sensing(*k));
        match self.mixing {
            None => self.observation.spread(of_body.map(|k| jacobian.column(k))),
            Some(_) => {
                let of_make = self.unmixed(jacobian.clone());
                self.observation.spread(of_body.map(|k| of_make.column(k)))
            }
        }
    }

    /// For errors of a walk with these sensitivities; `None` where their covariance is not positive
    /// definite.
    pub(crate) fn whitening(&self, jacobian: &DMatrix<f64>) -> Option<Whitening> {
        self.observation
            .whitening(self.spread(jacobian), Compared::Walk)
    }

    /// These coordinates with a body as described; sensor and effects stay as they are.
    pub(crate) fn with_body_described(&self, mut z: DVector<f64>) -> DVector<f64> {
        for k in 0..self.nuisances() {
            if !self.is_of_sensing(k) {
                z[k] = 0.0;
            }
        }
        z
    }

    /// Whether the body walks the same whatever the value of coordinate `k`.
    pub(crate) fn is_of_sensing(&self, k: usize) -> bool {
        match &self.coordinates[k] {
            Coordinate::Nuisance(nuisance) => nuisance.is_of_sensing(),
            Coordinate::Replaced(_) => true,
            Coordinate::Effect { effect, .. } => {
                self.hypothesis.effects[*effect].effect.is_of_sensing()
            }
        }
    }
}

#[cfg(test)]
mod tests;
