//! report.html: one page without scripts and without anything to load.

use super::figures::{self, Figure};
use super::{ReportError, style, table};
use crate::outcome::Outcome;

const STYLE: &str = include_str!("page.css");

/// The whole page.
pub(super) fn render(outcomes: &[Outcome]) -> Result<String, ReportError> {
    let figures = if outcomes.iter().any(|outcome| outcome.rows.is_empty()) {
        "<p>No figures: there is a run without a tick of its trajectory.</p>".into()
    } else {
        figures::all(outcomes)?.iter().map(figure).collect::<String>()
    };
    let body = format!("{}\n{}\n{figures}", runs(outcomes), table3(outcomes));
    Ok(framed(&title(outcomes), &body))
}

/// A page with a title.
pub(super) fn framed(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n{body}</main>\n</body>\n</html>\n",
        style::dash_rules(),
    )
}

fn title(outcomes: &[Outcome]) -> String {
    let mut names: Vec<&str> = outcomes.iter().map(|outcome| outcome.scenario.as_str()).collect();
    names.dedup();
    format!("Lifting arm, {}", names.join(" and "))
}

/// What was run and how it ended, one line a run.
fn runs(outcomes: &[Outcome]) -> String {
    let header =
        ["controller", "verdict", "mode at the end", "faults", "tick rate", "seed", "speed"];
    let rows: Vec<_> = outcomes.iter().map(run).collect();
    let broken: String = outcomes
        .iter()
        .flat_map(|o| o.broken_limits.iter().map(|limit| format!("{}: {limit}", o.label())))
        .map(|sentence| format!("<li>{}</li>\n", escape(&sentence)))
        .collect();
    let list =
        if broken.is_empty() { broken } else { format!("<ul class=\"broken\">\n{broken}</ul>") };
    html_table(&header.map(String::from), &rows) + &list
}

fn run(outcome: &Outcome) -> Vec<String> {
    let verdict = match outcome.broken_limits.len() {
        0 if outcome.is_good() => "passed".into(),
        0 => "failed: fault".into(),
        1 => "failed: 1 limit broken".into(),
        n => format!("failed: {n} limits broken"),
    };
    let faults = if outcome.faults.is_empty() { "none".into() } else { outcome.faults.join(", ") };
    vec![
        outcome.label().into(),
        verdict,
        outcome.mode.clone(),
        faults,
        format!("{} Hz", outcome.tick_hz),
        outcome.seed.to_string(),
        format!("{:.1} × real time", outcome.realtime_factor),
    ]
}

fn table3(outcomes: &[Outcome]) -> String {
    let table::Cells { header, rows } = table::cells(outcomes);
    format!(
        "<h2>Table 3. Tracking of the tip</h2>\n<div class=\"figures\">{}</div>\n<p class=\"note\">{}</p>\n",
        html_table(&header, &rows),
        unbroken(&escape(&table::impossible())),
    )
}

/// Keeps a browser from breaking a line within `1.0e-2`.
fn unbroken(text: &str) -> String {
    let keep = |word: &str| match word.contains("e-") {
        true => format!("<span class=\"number\">{word}</span>"),
        false => word.into(),
    };
    text.split(' ').map(keep).collect::<Vec<_>>().join(" ")
}

pub(super) fn figure(figure: &Figure) -> String {
    let legend: String = figure
        .legend
        .iter()
        .map(|(name, stroke)| format!("<li>{}{}</li>", stroke.swatch(), escape(name)))
        .collect();
    let dropped = match figure.dropped {
        0 => String::new(),
        n => format!(" <strong>Values left out because they are not finite: {n}.</strong>"),
    };
    format!(
        "<figure>\n<h2>{}</h2>\n<ul class=\"legend\">{legend}</ul>\n<div class=\"panels\">\n{}</div>\n\
         <figcaption>{}{dropped}</figcaption>\n</figure>\n",
        escape(&figure.title),
        figure.panels.concat(),
        escape(&figure.caption),
    )
}

pub(super) fn html_table(header: &[String], rows: &[Vec<String>]) -> String {
    let line = |tag: &str, cells: &[String]| {
        let cells: String =
            cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let body: String = rows.iter().map(|row| line("td", row)).collect();
    format!("<div class=\"scroll\"><table>\n{}{body}</table></div>\n", line("th", header))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
