//! `[[fault]]` and `[expect]`: what is injected, and what must come of it.

use std::ops::Range;

use shared::fault::Fault;
use toml::Spanned;

use super::LIKENESS;
use super::bounds::{self, Bounds};
use super::error::{ScenarioError, Source};
use super::raw::{Leaf, RawFault};
use crate::faults::{Injection, Kind, SPECS, Span, Target};

type Checked<T> = Result<T, ScenarioError>;

impl Source<'_> {
    /// Faults of a run that ends `duration_s` after the trajectory's start.
    pub(super) fn faults(
        &self,
        raw: &[Spanned<RawFault>],
        duration_s: f64,
    ) -> Checked<Vec<Injection>> {
        let at_s = Bounds { hi: duration_s, ..bounds::FAULT_AT_S };
        raw.iter().map(|raw| self.injection(raw.get_ref(), &raw.span(), &at_s)).collect()
    }

    fn injection(&self, raw: &RawFault, table: &Range<usize>, at_s: &Bounds) -> Checked<Injection> {
        let kind = self.kind(&raw.kind, table)?;
        let target = self.target(kind, &raw.target, table)?;
        let injection = Injection::new(kind, target, f64::NEG_INFINITY);
        if kind.spec().span == Span::PowerUp {
            let why = "it is there at power-up, and has no other time";
            self.absent(&raw.at_s, "fault.at_s", kind, why)?;
            self.absent(&raw.for_s, "fault.for_s", kind, why)?;
            return Ok(Injection { severity: self.severity(raw, &injection, table)?, ..injection });
        }
        Ok(Injection {
            at_s: self.required_number(&raw.at_s, at_s, table)?,
            for_s: self.duration(&raw.for_s)?,
            severity: self.severity(raw, &injection, table)?,
            ..injection
        })
    }

    fn kind(&self, leaf: &Leaf, table: &Range<usize>) -> Checked<Kind> {
        let leaf = self.given(leaf, "fault.kind", table, "the name of a kind of fault")?;
        let written = leaf.get_ref().as_str();
        let names = SPECS.iter().map(|spec| spec.name);
        written.and_then(Kind::named).ok_or_else(|| self.unknown("fault.kind", leaf, names))
    }

    fn target(&self, kind: Kind, leaf: &Leaf, table: &Range<usize>) -> Checked<Target> {
        let targets = kind.spec().targets;
        if targets == [Target::Only] {
            self.absent(leaf, "fault.target", kind, "there is but one place for it")?;
            return Ok(Target::Only);
        }
        let names = targets.iter().map(|target| format!("\"{target}\"")).collect::<Vec<_>>();
        let allowed = names.join(" or ");
        let leaf = self.given(leaf, "fault.target", table, &allowed)?;
        let written = leaf.get_ref().as_str().unwrap_or_default();
        let target = targets.iter().find(|target| target.to_string() == written);
        target.copied().ok_or_else(|| {
            let at = leaf.span();
            let message = format!("`fault.target` = {} is no place for `{kind}`", self.quoted(&at));
            self.error(&at, message, format!("allowed: {allowed}"), "")
        })
    }

    fn duration(&self, leaf: &Leaf) -> Checked<Option<f64>> {
        leaf.as_ref().map(|_| self.number(leaf, &bounds::FAULT_FOR_S, 0.0)).transpose()
    }

    fn severity(&self, raw: &RawFault, of: &Injection, table: &Range<usize>) -> Checked<f64> {
        let Some(severity) = of.kind.severity(of.target) else {
            let why = "such a fault is there or is not";
            return self.absent(&raw.severity, "fault.severity", of.kind, why).map(|()| 0.0);
        };
        let value = match severity.default {
            Some(default) => self.number(&raw.severity, &severity.bounds, default)?,
            None => self.required_number(&raw.severity, &severity.bounds, table)?,
        };
        let own = of.target.joints().map(|j| (j + 1) as f64).next();
        match &raw.severity {
            Some(leaf) if of.kind == Kind::Swap && own == Some(value) => {
                let at = leaf.span();
                let message =
                    format!("`fault.severity` = {} is the encoder itself", self.quoted(&at));
                Err(self.error(&at, message, "allowed: another one", severity.bounds.why))
            }
            _ => Ok(value),
        }
    }

    fn absent(&self, leaf: &Leaf, key: &str, kind: Kind, why: &str) -> Checked<()> {
        let Some(leaf) = leaf else { return Ok(()) };
        let message = format!("`{key}` has no meaning for `{kind}`");
        Err(self.error(&leaf.span(), message, "allowed: nothing", why))
    }

    pub(super) fn expected(&self, leaf: &Leaf) -> Checked<Option<Fault>> {
        let Some(leaf) = leaf else { return Ok(None) };
        let faults = || Fault::ALL.iter().filter(|fault| **fault != Fault::None);
        let written = leaf.get_ref().as_str().unwrap_or_default();
        let fault = faults().find(|fault| fault.name() == written);
        let names = faults().map(|fault| fault.name());
        fault.map(|fault| Some(*fault)).ok_or_else(|| self.unknown("expect.fault", leaf, names))
    }

    /// The error for a name that is none of many.
    fn unknown(
        &self,
        key: &str,
        leaf: &Spanned<toml::Value>,
        names: impl Iterator<Item = &'static str> + Clone,
    ) -> ScenarioError {
        let at = leaf.span();
        let likeness =
            |name: &str| strsim::jaro_winkler(name, leaf.get_ref().as_str().unwrap_or_default());
        let closest = names.clone().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let label = match closest.filter(|name| likeness(name) >= LIKENESS) {
            Some(name) => format!("did you mean \"{name}\"?"),
            None => "not known".to_owned(),
        };
        let message = format!("`{key}` = {} is not one of its choices", self.quoted(&at));
        let allowed = format!("allowed: {}", names.collect::<Vec<_>>().join(", "));
        self.error(&at, message, label, &allowed)
    }
}
