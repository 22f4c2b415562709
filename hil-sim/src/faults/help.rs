//! The table of faults as text.

use super::{SPECS, Severity, Span, Spec, Target};

/// Every kind with its targets, its effect and its severity, for the command line's help.
pub fn table() -> String {
    SPECS.iter().map(entry).collect::<Vec<_>>().join("\n")
}

fn entry(spec: &Spec) -> String {
    let span = match spec.span {
        Span::Lasting => "",
        Span::Once => " Lasts one tick.",
        Span::PowerUp => " At power-up only.",
    };
    let severity =
        spec.severity.map(|severity| format!("\n      severity: {}", range(spec, severity)));
    let targets = targets(spec.targets);
    format!(
        "  {:<18}{targets}\n      {}{span}{}",
        spec.name,
        spec.what,
        severity.unwrap_or_default()
    )
}

fn range(spec: &Spec, Severity { bounds, default }: Severity) -> String {
    let hi = if spec.targets.iter().any(|target| matches!(target, Target::Place(_))) {
        " (fewer in a smaller place)"
    } else {
        ""
    };
    let usual = default.map_or("must be given".into(), |default| format!("default {default}"));
    format!("{}, {bounds}{hi}, {usual}", bounds.why)
}

fn targets(targets: &[Target]) -> String {
    if targets == [Target::Only] {
        return "no target".into();
    }
    let names = targets.iter().map(Target::to_string).collect::<Vec<_>>().join(", ");
    ["encoder", "joint", "brake"].iter().fold(names, |names, one| {
        names.replace(&format!("{one}1, {one}2, {one}3, {one}4"), &format!("{one}1..4"))
    })
}
