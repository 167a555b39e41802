//! The effects of the likeliest hypothesis on the other robots that are weighed.

use std::sync::Arc;

use mlr_model::Morphology;

use super::{Judged, Search, base::Base, weighing::Weighed};
use crate::walk::{
    evidence::Fit,
    hypothesis::{Placement, Walker},
};

impl<'a> Search<'a, '_> {
    /// These hypotheses, and those that each robot has the effects of the likeliest one, as far as it may.
    ///
    /// An effect is found on the robot that is likeliest at first. Others may have it as well, and else be behind for
    /// no other reason than that it was not tried on them.
    pub(super) fn with_effects_on_other_robots(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let all = weighed.all();
        let Some(likeliest) = all.first() else {
            return weighed;
        };
        let effects = &likeliest.hypothesis().effects;
        let has_them = |base: &Arc<Base<'a>>| {
            let mut on_it = all.iter().filter(|one| Arc::ptr_eq(&one.base, base));
            on_it.any(|one| one.is_weighed() && one.hypothesis().effects == *effects)
        };
        let mut robots = robots_weighed(&all);
        robots.retain(|base| !has_them(base));
        self.progress.expect_more(robots.len());
        for base in robots {
            let with = self.with_effects_of(&likeliest.walker, &likeliest.fit, &base);
            self.weigh_too(&mut weighed, Vec::from_iter(with), &[]);
            self.progress.advance();
        }
        weighed
    }

    /// The hypothesis that a robot has the effects of this one that is fitted, from its own parameters and from those of
    /// the fit. `None` where it cannot have one of them.
    pub(super) fn with_effects_of(
        &self,
        walker: &Walker<'a>,
        fit: &Fit,
        base: &Arc<Base<'a>>,
    ) -> Option<Judged<'a>> {
        let effects = &walker.hypothesis.effects;
        if effects.is_empty() || !self.may_have(&base.morphology, effects) {
            return None;
        }
        let other = base.with(effects.clone());
        let found = other.with_parameters_of(walker, &fit.walked.z);
        let beside_its_own = base.beside_reference(&other, &other.values(&found));
        self.fitted_from(base, other, vec![beside_its_own, found])
    }

    /// Whether a robot has the places of all these effects.
    pub(super) fn may_have(&self, morphology: &Morphology, effects: &[Placement]) -> bool {
        let robot = &self.setting.nominal.robot;
        effects.iter().all(|one| {
            let places = one.effect.places(robot, morphology);
            places.contains(&one.place)
        })
    }
}

/// The robots of hypotheses that are weighed, each once.
pub(super) fn robots_weighed<'a>(all: &[Judged<'a>]) -> Vec<Arc<Base<'a>>> {
    let mut robots: Vec<Arc<Base<'a>>> = Vec::new();
    for one in all.iter().filter(|one| one.is_weighed()) {
        if !robots.iter().any(|base| Arc::ptr_eq(base, &one.base)) {
            robots.push(Arc::clone(&one.base));
        }
    }
    robots
}
