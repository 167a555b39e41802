//! Scored explanations as text.

use mlr_ga::scoring::{
    EffectsScore, EffectsTotal, Errors, KindsTotal, LOG_SCORE_FLOOR, LogClass, Origin, TrueEffect,
    UnansweredLog, Verdict, Visibility, in_words,
};

use super::{evaluate_effects::Report, markdown::MarkdownTable};

/// Kinds of an explanation whose probabilities are shown, and the least that is.
const TOP: (usize, f64) = (3, 0.005);

/// Markdown: reads well as it is, and in a document.
pub(super) fn tables(report: &Report) -> String {
    let mut table = MarkdownTable::new(&[
        "log",
        "truth",
        "class",
        "found",
        "most probable",
        "verdict",
        "fitted [°]",
        "unseen [°]",
        "legs",
        "unexplained",
        "time [s]>",
    ]);
    for score in &report.logs {
        table.row(row(score));
    }
    for log in &report.unanswered {
        table.row(unanswered_row(log));
    }
    let mut text = table.into_text();
    for total in &report.totals {
        text += "\n";
        text += &total_text(total);
    }
    text
}

fn row(score: &EffectsScore) -> [String; 11] {
    let arrow = |pick: fn(&Errors) -> f64| {
        format!(
            "{:.2} → {:.2} → {:.2}",
            pick(&score.error_before),
            pick(&score.error_calibrated),
            pick(&score.error_after)
        )
    };
    let found = score.found.iter().map(|effect| {
        let words = format!("{} {}", effect.kind, in_words(&effect.parameters));
        words.trim_end().to_string()
    });
    let (most, least) = TOP;
    let top = score.kinds.top(most).into_iter();
    let top: Vec<String> = top
        .filter(|one| one.probability >= least)
        .map(|one| format!("{} {:.0} %", one.kind, 100.0 * one.probability))
        .collect();
    let legs = match (score.legs_right_before, score.legs_right) {
        (true, true) => "right",
        (false, true) => "WRONG → right",
        (true, false) => "right → WRONG",
        (false, false) => "WRONG",
    };
    [
        score.log.clone(),
        truth_in_words(&score.truth),
        class_in_words(score),
        or_none(&found.collect::<Vec<_>>()),
        top.join(", "),
        verdict_in_words(score),
        arrow(|error| error.fit_deg),
        arrow(|error| error.validation_deg),
        legs.into(),
        if score.unexplained { "yes" } else { "no" }.into(),
        format!("{:.0}", score.elapsed_s),
    ]
}

fn unanswered_row(log: &UnansweredLog) -> Vec<String> {
    vec![
        log.log.clone(),
        truth_in_words(&log.truth),
        class_name(log.class).into(),
        format!("no answer: {}", log.reason),
    ]
}

fn or_none(words: &[String]) -> String {
    match words.is_empty() {
        true => "none".into(),
        false => words.join("; "),
    }
}

fn truth_in_words(truth: &[TrueEffect]) -> String {
    let words: Vec<String> = truth.iter().map(TrueEffect::in_words).collect();
    or_none(&words)
}

fn class_name(class: LogClass) -> &'static str {
    match class {
        LogClass::Visible => "visible",
        LogClass::Hidden => "hidden",
        LogClass::NotRecorded => "library",
        LogClass::Undisturbed => "undisturbed",
        LogClass::OutsideVisible => "outside",
        LogClass::OutsideHidden => "outside, hidden",
        LogClass::OutsideNotRecorded => "outside, not recorded",
    }
}

fn class_in_words(score: &EffectsScore) -> String {
    let name = class_name(score.class);
    match (score.class, score.visibility) {
        (LogClass::Visible | LogClass::OutsideVisible, Visibility::WithinSpread) => {
            format!("{name}, within spread")
        }
        _ => name.into(),
    }
}

fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Right => "right",
        Verdict::Incomplete => "incomplete",
        Verdict::Partly => "partly",
        Verdict::WrongLegs => "WRONG LEGS",
        Verdict::Missed => "missed",
        Verdict::Wrong => "WRONG",
    }
}

/// The verdict on kinds and legs, and whether an effect was found at a wrong place.
fn verdict_in_words(score: &EffectsScore) -> String {
    let name = verdict_name(score.verdict);
    let elsewhere = |place: &mlr_ga::scoring::PlaceScore| place.kind_found && !place.place_right;
    match score.places.iter().any(elsewhere) {
        true => format!("{name}, other place"),
        false => name.into(),
    }
}

fn total_text(total: &EffectsTotal) -> String {
    let title = match total.origin {
        Origin::Drawn => "Logs drawn by the plant:",
        Origin::StandIn => {
            "Stand-in logs, which were in view while the program was made and prove little:"
        }
    };
    let mut text = format!("{title}\n\n{}\n", classes_text(total));
    text += VERDICTS;
    text += "\n";
    let mut line = |label: &str, words: String| text += &format!("{label:<32}{words}\n");
    let standing_out = total.standing_out;
    if standing_out.logs > 0 {
        line(
            "visible beyond the spread",
            format!("{} logs: right {}", standing_out.logs, standing_out.right),
        );
    }
    let several = total.several_effects;
    if several.logs > 0 {
        line(
            "several effects, not hidden",
            format!("{} logs: all found {}", several.logs, several.right),
        );
    }
    let places = total.places;
    if places.effects > 0 {
        line(
            "effects of a leg, not hidden",
            format!(
                "{}: kind found {}, of these on the right leg {}, and on the right link or joint {}",
                places.effects, places.kind_found, places.leg_right, places.place_right
            ),
        );
    }
    let legs = total.legs;
    line(
        "damaged legs",
        format!(
            "{} logs: right {} before, {} after; right before but wrong after {}, the other way {}",
            legs.logs, legs.right_before, legs.right_after, legs.lost, legs.won
        ),
    );
    if let Some(elapsed) = total.elapsed_s {
        line(
            "time of an answer",
            format!(
                "{:.0} s (median), {:.0} s at most, each on one thread",
                elapsed.median_s, elapsed.longest_s
            ),
        );
    }
    match &total.kinds {
        Some(kinds) => text + &kinds_text(kinds),
        None => text,
    }
}

/// What the columns of the classes mean.
const VERDICTS: &str = "\
right: every effect of the robot and no other, on the right damaged legs; incomplete: some effects
not found; partly: also one that is not there; wrong legs: right or incomplete but for the legs;
missed: nothing found; wrong: only what is not there. The mark `unexplained` counts as an effect:
right where the library lacks one, not there elsewhere; `but for mark` are the logs that would be
right without it. Locked links count where they hang on; they must be found where they are listed.
Errors: median of after over before, and over calibrated, on the unseen stretch.
";

fn classes_text(total: &EffectsTotal) -> String {
    let mut columns = vec!["class".to_string(), "logs>".into()];
    columns.extend(Verdict::ALL.map(|v| format!("{}>", verdict_name(v).to_lowercase())));
    columns.extend(
        [
            "no answer>",
            "unexplained>",
            "but for mark>",
            "ln P(truth)>",
            "after/before>",
            "after/calibrated>",
        ]
        .map(String::from),
    );
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = MarkdownTable::new(&columns);
    let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
    for class in &total.classes {
        let mut cells = vec![class_title(class.class).to_string(), class.logs.to_string()];
        cells.extend(class.verdicts.map(|count| count.to_string()));
        cells.push(class.unanswered.to_string());
        cells.push(class.unexplained.to_string());
        cells.push(class.right_but_for_mark.to_string());
        cells.push(number(class.mean_ln_probability));
        cells.push(number(class.median_error_ratio));
        cells.push(number(class.median_calibrated_ratio));
        table.row(cells);
    }
    table.into_text()
}

fn class_title(class: LogClass) -> &'static str {
    match class {
        LogClass::Visible => "of the library, visible",
        LogClass::Hidden => "of the library, hidden",
        LogClass::NotRecorded => "of the library, visibility not recorded",
        LogClass::Undisturbed => "undisturbed",
        LogClass::OutsideVisible => "outside the library, visible",
        LogClass::OutsideHidden => "outside the library, hidden",
        LogClass::OutsideNotRecorded => "outside the library, visibility not recorded",
    }
}

fn kinds_text(kinds: &KindsTotal) -> String {
    let lines = [
        (
            "logarithmic score",
            format!(
                "{:.2} (mean ln of the truth's probability; one below {LOG_SCORE_FLOOR} counts as that)",
                kinds.mean_ln_probability
            ),
        ),
        (
            "Brier score",
            format!("{:.3} (sum over kinds, mean over logs)", kinds.mean_brier),
        ),
        (
            "90 % credible set of kinds",
            format!(
                "holds the truth on {} of {} logs; {} kinds (median)",
                kinds.credible.right, kinds.credible.logs, kinds.median_credible_kinds
            ),
        ),
        (
            "more than 90 % for a kind",
            format!(
                "{} answers: kind true {}, whole answer right {}",
                kinds.sure.logs, kinds.sure.right, kinds.sure_and_right
            ),
        ),
    ];
    let lines: String = lines
        .into_iter()
        .map(|(label, words)| format!("{label:<32}{words}\n"))
        .collect();
    let mut table = MarkdownTable::new(&[
        "probability of a kind>",
        "statements>",
        "mean>",
        "true>",
        "share>",
    ]);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    for row in &kinds.calibration {
        let mean = row.mean_probability;
        table.row([
            format!(
                "{:.0} to {:.0} %",
                100.0 * row.probability[0],
                100.0 * row.probability[1]
            ),
            row.statements.to_string(),
            mean.map_or("-".into(), percent),
            row.true_ones.to_string(),
            mean.map_or("-".into(), |_| {
                percent(row.true_ones as f64 / row.statements as f64)
            }),
        ]);
    }
    format!("{lines}\n{}", table.into_text())
}
