//! What was done to the robots whose walks are explained.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use mlr_imu::read_text;
use mlr_model::LegLayout;
use mlr_residual::{walk::Reported, walk_effects};
use serde::{Deserialize, Serialize};

use super::{
    truth::{FILE, MAX_BYTES, Truth, TruthError, read_truths},
    visibility::{TrueTrace, Visibility},
};

/// What was done to the robot of a log beyond its lost links.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectsTruth {
    /// The log, and what was left of the robot.
    pub log: Truth,
    /// Whether lost links are locked instead of absent.
    pub locked: bool,
    /// The undeclared effects.
    pub effects: Vec<TrueEffect>,
    /// Log time at which the walk was commanded.
    pub motion_start_s: Option<f64>,
    /// What they change of the walk, where that was recorded.
    pub trace: Option<TrueTrace>,
    /// Where the log comes from.
    pub origin: Origin,
}

/// An effect as it was put into the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrueEffect {
    /// Its kind.
    pub kind: String,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
}

/// Where a log comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Drawn by the plant, which lists the effects of each log.
    Drawn,
    /// A stand-in: no entry of the directory lists effects or traces. These logs were in view
    /// while the program was made.
    StandIn,
}

/// What there was to find in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LogClass {
    /// Effects of the library that can be seen.
    Visible,
    /// Effects of the library that change the walk by less than is usual.
    Hidden,
    /// Effects of the library whose change of the walk was not recorded.
    NotRecorded,
    /// Nothing but lost links.
    Undisturbed,
    /// An effect that the library does not have, and that can be seen.
    OutsideVisible,
    /// An effect that the library does not have, and that cannot be seen.
    OutsideHidden,
    /// An effect that the library does not have, whose change of the walk was not recorded.
    OutsideNotRecorded,
}

impl LogClass {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 7] = [
        Self::Visible,
        Self::NotRecorded,
        Self::Hidden,
        Self::Undisturbed,
        Self::OutsideVisible,
        Self::OutsideNotRecorded,
        Self::OutsideHidden,
    ];

    /// Whether the library lacks an effect of the log.
    pub fn is_outside(self) -> bool {
        use LogClass::{OutsideHidden, OutsideNotRecorded, OutsideVisible};
        matches!(self, OutsideVisible | OutsideHidden | OutsideNotRecorded)
    }

    /// Whether the log has an effect, the library every one of them, and nothing says that they
    /// cannot be seen.
    pub fn is_findable(self) -> bool {
        matches!(self, Self::Visible | Self::NotRecorded)
    }
}

/// Lost links that hang on: part of the damage, and an effect only where a log lists it.
pub(super) const LOCKED: &str = "locked_links";
/// What the probabilities of kinds call something that no effect of the library makes.
pub(super) const UNKNOWN: &str = "unknown";
/// What they call a robot that lacks nothing but links.
pub(super) const NONE: &str = "none";

#[derive(Deserialize)]
struct Entry {
    #[serde(default)]
    locked: bool,
    #[serde(default)]
    effect: Option<OneEffect>,
    #[serde(default)]
    effects: Option<Vec<TrueEffect>>,
    #[serde(default)]
    motion_start_s: Option<f64>,
    #[serde(default)]
    trace: Option<TrueTrace>,
}

/// Some sets name a log's effect only.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneEffect {
    Name(String),
    Whole(TrueEffect),
}

/// Reads a directory's `truth.json`: like [`read_truths`], with the effects.
///
/// # Errors
/// [`TruthError`] names the file and the entry at fault.
pub fn read_effects_truths(
    directory: &Path,
    layout: &LegLayout,
) -> Result<Vec<EffectsTruth>, TruthError> {
    let truths = read_truths(directory, layout)?;
    let path = directory.join(FILE);
    let fail = |problem: String| TruthError {
        path: path.clone(),
        problem,
    };
    let text = read_text(&path, MAX_BYTES).map_err(|error| fail(error.to_string()))?;
    let mut entries: BTreeMap<String, Entry> =
        serde_json::from_str(&text).map_err(|error| fail(error.to_string()))?;
    let is_drawn = |entry: &Entry| entry.trace.is_some() || entry.effects.is_some();
    let origin = match entries.values().any(is_drawn) {
        true => Origin::Drawn,
        false => Origin::StandIn,
    };
    Ok(truths
        .into_iter()
        .filter_map(|log| {
            let entry = entries.remove(&log.name)?;
            let named = entry.effect.map(|effect| match effect {
                OneEffect::Name(kind) => TrueEffect {
                    kind,
                    parameters: BTreeMap::new(),
                },
                OneEffect::Whole(effect) => effect,
            });
            Some(EffectsTruth {
                log,
                locked: entry.locked,
                effects: entry.effects.unwrap_or_else(|| named.into_iter().collect()),
                motion_start_s: entry.motion_start_s,
                trace: entry.trace,
                origin,
            })
        })
        .collect())
}

impl EffectsTruth {
    /// Whether its effects can be seen. A delay cannot where nobody says when the walk was
    /// commanded.
    pub fn visibility(&self, start_told: bool) -> Visibility {
        let is_a_delay = |effect: &TrueEffect| {
            walk_effects::find(&effect.kind).is_some_and(|known| known.is_a_delay())
        };
        let only_delays = !self.effects.is_empty() && self.effects.iter().all(is_a_delay);
        match self.trace {
            Some(_) if only_delays && !start_told => Visibility::Hidden,
            Some(trace) => trace.visibility(),
            None => Visibility::Unknown,
        }
    }

    /// What there is to find in it.
    pub fn class(&self, start_told: bool) -> LogClass {
        let in_library = self.effects.iter().all(TrueEffect::is_in_library);
        let visibility = self.visibility(start_told);
        match (in_library, visibility) {
            _ if self.effects.is_empty() => LogClass::Undisturbed,
            (true, Visibility::Unknown) => LogClass::NotRecorded,
            (true, Visibility::Hidden) => LogClass::Hidden,
            (true, _) => LogClass::Visible,
            (false, Visibility::Unknown) => LogClass::OutsideNotRecorded,
            (false, Visibility::Hidden) => LogClass::OutsideHidden,
            (false, _) => LogClass::OutsideVisible,
        }
    }

    /// What an explanation should find.
    pub(super) fn kinds(&self) -> TrueKinds {
        let name = |effect: &TrueEffect| match effect.is_in_library() {
            true => effect.kind.clone(),
            false => UNKNOWN.to_string(),
        };
        let effects: BTreeSet<String> = self.effects.iter().map(name).collect();
        let hang_on = self.locked && !self.log.morphology.is_healthy();
        TrueKinds {
            locked: hang_on || effects.contains(LOCKED),
            effects,
        }
    }
}

/// The kinds of effects in a robot, as the probabilities of kinds name them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrueKinds {
    /// Those to be found: locked links only where they are listed, `unknown` for every kind that
    /// the library does not have.
    pub(super) effects: BTreeSet<String>,
    /// Whether lost links hang on, listed or not.
    pub(super) locked: bool,
}

impl TrueKinds {
    /// Whether it is true that the robot has this kind.
    pub(super) fn has(&self, kind: &str) -> bool {
        match kind {
            LOCKED => self.locked,
            NONE => self.effects.is_empty() && !self.locked,
            kind => self.effects.contains(kind),
        }
    }

    /// Whether nothing is wrong with the robot but its lost links, whether these hang on or not.
    pub(super) fn is_damage_only(&self) -> bool {
        self.effects.iter().all(|kind| kind == LOCKED)
    }
}

impl TrueEffect {
    fn is_in_library(&self) -> bool {
        self.kind == LOCKED || walk_effects::find(&self.kind).is_some()
    }

    /// The number of the leg, link or joint that it is on.
    pub(super) fn number(&self, name: &str) -> Option<usize> {
        let number = self.parameters.get(name)?.as_u64()?;
        usize::try_from(number).ok()
    }

    /// Kind and parameters in words.
    pub fn in_words(&self) -> String {
        let parameters: BTreeMap<String, Reported> = self
            .parameters
            .iter()
            .filter_map(|(name, value)| {
                Some((name.clone(), serde_json::from_value(value.clone()).ok()?))
            })
            .collect();
        format!("{} {}", self.kind, in_words(&parameters))
            .trim_end()
            .to_string()
    }
}

/// The parameters of an effect, in words.
pub fn in_words(parameters: &BTreeMap<String, Reported>) -> String {
    let words = parameters
        .iter()
        .map(|(name, value)| format!("{name} {value}"));
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Truths of a directory of logs of a robot with two legs of one link, without leg 2.
    fn truths(entries: &[(&str, &str)]) -> Vec<EffectsTruth> {
        let folder = tempfile::tempdir().unwrap();
        let mut json = Vec::new();
        for (name, fields) in entries {
            fs::write(folder.path().join(format!("{name}.csv")), "").unwrap();
            json.push(format!(r#""{name}": {{"morphology": [[1], [0]]{fields}}}"#));
        }
        fs::write(folder.path().join(FILE), format!("{{{}}}", json.join(", "))).unwrap();
        read_effects_truths(folder.path(), &LegLayout::new([1, 1]).unwrap()).unwrap()
    }

    const SEEN: &str = r#", "trace": {"mean_deg": [0, 0, 0], "swing_deg": [1, 0, 0]}"#;
    const UNSEEN: &str = r#", "trace": {"mean_deg": [0, 0, 0], "swing_deg": [0.1, 0, 0]}"#;

    fn with(kind: &str, trace: &str) -> String {
        format!(r#", "effects": [{{"kind": "{kind}", "parameters": {{}}}}]{trace}"#)
    }

    #[test]
    fn each_log_is_of_one_class() {
        let fields = [
            (LogClass::Visible, with("payload", SEEN)),
            (LogClass::Hidden, with("payload", UNSEEN)),
            (LogClass::NotRecorded, with("payload", "")),
            (LogClass::Undisturbed, r#", "effects": []"#.to_string()),
            (LogClass::OutsideVisible, with("loose_mount", SEEN)),
            (LogClass::OutsideHidden, with("loose_mount", UNSEEN)),
            (LogClass::OutsideNotRecorded, with("loose_mount", "")),
            (LogClass::Hidden, with("sensor_delay", SEEN)),
            (LogClass::Visible, with("locked_links", SEEN)),
            (LogClass::Visible, with("joint_friction", SEEN)),
            (LogClass::Hidden, with("backlash", UNSEEN)),
        ];
        let names: Vec<String> = (0..fields.len()).map(|k| format!("log-{k:02}")).collect();
        let entries: Vec<(&str, &str)> = names
            .iter()
            .zip(&fields)
            .map(|(name, (_, fields))| (name.as_str(), fields.as_str()))
            .collect();
        let truths = truths(&entries);
        for (truth, (class, _)) in truths.iter().zip(&fields) {
            assert_eq!(truth.class(false), *class, "{:?}", truth.effects);
            assert_eq!(truth.origin, Origin::Drawn);
        }
        // Told when the walk was commanded, a delay shows.
        assert_eq!(truths[7].class(true), LogClass::Visible);
        assert_eq!(truths[1].class(true), LogClass::Hidden);
    }

    #[test]
    fn stand_ins_are_told_from_drawn_logs() {
        let named = r#", "effect": "payload""#;
        assert_eq!(
            truths(&[("a", named), ("b", r#", "effect": null"#)])[1].origin,
            Origin::StandIn
        );
        // Undisturbed logs of the plant have no traces, but it lists their effects: none.
        assert_eq!(
            truths(&[("a", r#", "effects": [], "effect": null"#)])[0].origin,
            Origin::Drawn
        );
        assert_eq!(
            truths(&[("a", named), ("b", SEEN)])[0].origin,
            Origin::Drawn
        );
    }

    #[test]
    fn locked_links_are_an_effect_where_they_are_listed() {
        let listed = with("locked_links", SEEN);
        let truths = truths(&[
            ("a", r#", "locked": true"#),
            ("b", &format!(r#", "locked": true{listed}"#)),
            ("c", ""),
        ]);
        let kinds: Vec<TrueKinds> = truths.iter().map(EffectsTruth::kinds).collect();
        assert_eq!([0, 1, 2].map(|k| kinds[k].locked), [true, true, false]);
        assert_eq!([0, 1, 2].map(|k| kinds[k].effects.len()), [0, 1, 0]);
        assert_eq!([0, 1, 2].map(|k| kinds[k].has(NONE)), [false, false, true]);
        assert!(kinds.iter().all(TrueKinds::is_damage_only));
    }

    #[test]
    fn every_kind_outside_the_library_is_unknown() {
        let truths = truths(&[("a", &with("loose_mount", SEEN))]);
        let kinds = truths[0].kinds();
        assert!(kinds.has(UNKNOWN) && !kinds.has("loose_mount") && !kinds.has(NONE));
    }
}
