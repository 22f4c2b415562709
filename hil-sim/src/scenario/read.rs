//! Reads single values: type, finiteness and range, with an error that names all of them.

use std::ops::Range;

use clap::ValueEnum;
use shared::arm::JOINTS;
use toml::Value;
use toml::de::DeValue;

use super::bounds::{Bounds, Kind};
use super::error::{ScenarioError, Source};
use super::raw::Leaf;

impl Source<'_> {
    /// A number, or `default` where the key is absent.
    pub fn number(&self, leaf: &Leaf, bounds: &Bounds, default: f64) -> Result<f64, ScenarioError> {
        match leaf {
            Some(leaf) => self.checked(leaf.get_ref(), &leaf.span(), bounds.key, bounds),
            None => Ok(default),
        }
    }

    /// A number that must be given; `table` is where it is missing.
    pub fn required_number(
        &self,
        leaf: &Leaf,
        bounds: &Bounds,
        table: &Range<usize>,
    ) -> Result<f64, ScenarioError> {
        self.given(leaf, bounds.key, table, &bounds.to_string())?;
        self.number(leaf, bounds, bounds.lo)
    }

    /// Four numbers, or `default` where the key is absent; each joint has its own range.
    pub fn four(
        &self,
        leaf: &Leaf,
        bounds: &[Bounds; JOINTS],
        default: [f64; JOINTS],
    ) -> Result<[f64; JOINTS], ScenarioError> {
        let Some(leaf) = leaf else { return Ok(default) };
        let [first, ..] = bounds;
        let at = leaf.span();
        let Some(values) = leaf.get_ref().as_array() else {
            return Err(self.refused(&at, first.key, "is not a list of four numbers", first));
        };
        if values.len() != JOINTS {
            let problem = format!("has {} entries and not four", values.len());
            return Err(self.refused(&at, first.key, &problem, first));
        }
        let mut four = default;
        for (joint, (value, bounds)) in values.iter().zip(bounds).enumerate() {
            let name = format!("{} (joint {})", bounds.key, joint + 1);
            four[joint] = self.checked(value, &self.entry(&at, joint), &name, bounds)?;
        }
        Ok(four)
    }

    /// `true` or `false`, or `false` where the key is absent.
    pub fn flag(&self, leaf: &Leaf, key: &str) -> Result<bool, ScenarioError> {
        let Some(leaf) = leaf else { return Ok(false) };
        let at = leaf.span();
        leaf.get_ref().as_bool().ok_or_else(|| {
            let message = format!("`{key}` = {} is not a truth value", self.quoted(&at));
            self.error(&at, message, "allowed: true or false", "")
        })
    }

    /// One of the names of an enum, or `default` where the key is absent.
    pub fn choice<T: ValueEnum>(
        &self,
        leaf: &Leaf,
        key: &str,
        default: T,
    ) -> Result<T, ScenarioError> {
        let Some(leaf) = leaf else { return Ok(default) };
        let at = leaf.span();
        let choice = leaf.get_ref().as_str().and_then(|name| T::from_str(name, false).ok());
        choice.ok_or_else(|| {
            let message = format!("`{key}` = {} is not one of its choices", self.quoted(&at));
            self.error(&at, message, format!("allowed: {}", names::<T>()), "")
        })
    }

    /// A line of printable text that must be given.
    pub fn line(&self, leaf: &Leaf, key: &str) -> Result<String, ScenarioError> {
        const ALLOWED: &str = "one line of 1 to 100 printable characters, in quotes";
        let leaf = self.given(leaf, key, &(0..0), ALLOWED)?;
        let printable = |text: &&str| {
            (1..=100).contains(&text.chars().count()) && !text.chars().any(char::is_control)
        };
        leaf.get_ref().as_str().filter(printable).map(str::to_owned).ok_or_else(|| {
            let message = format!("`{key}` is not a line of text");
            self.error(&leaf.span(), message, format!("allowed: {ALLOWED}"), "")
        })
    }

    /// The value of a key that must be given; `table` is where it is missing.
    pub fn given<'a>(
        &self,
        leaf: &'a Leaf,
        key: &str,
        table: &Range<usize>,
        allowed: &str,
    ) -> Result<&'a toml::Spanned<Value>, ScenarioError> {
        leaf.as_ref().ok_or_else(|| {
            let message = format!("`{key}` is missing");
            self.error(table, message, format!("needed here: {allowed}"), "")
        })
    }

    fn checked(
        &self,
        value: &Value,
        at: &Range<usize>,
        name: &str,
        bounds: &Bounds,
    ) -> Result<f64, ScenarioError> {
        let number = match (value, bounds.kind) {
            (Value::Integer(whole), _) => *whole as f64,
            (Value::Float(_), Kind::Whole) => {
                return Err(self.refused(at, name, "is not written as a whole number", bounds));
            }
            (Value::Float(real), _) => *real,
            _ => return Err(self.refused(at, name, "is not a number", bounds)),
        };
        if !number.is_finite() {
            return Err(self.refused(at, name, "is not finite", bounds));
        }
        if !bounds.contains(number) {
            return Err(self.refused(at, name, "is out of range", bounds));
        }
        Ok(number)
    }

    fn refused(
        &self,
        at: &Range<usize>,
        name: &str,
        problem: &str,
        bounds: &Bounds,
    ) -> ScenarioError {
        let message = format!("`{name}` = {} {problem}", self.quoted(at));
        self.error(at, message, format!("allowed: {bounds}"), bounds.why)
    }

    /// Place of one entry of the list at `list`.
    fn entry(&self, list: &Range<usize>, index: usize) -> Range<usize> {
        let within = self.text.get(list.clone()).and_then(|text| {
            let parsed = DeValue::parse(text).ok()?;
            Some(parsed.get_ref().as_array()?.get(index)?.span())
        });
        within.map_or(list.clone(), |at| list.start + at.start..list.start + at.end)
    }
}

/// The names of an enum as a file writes them.
pub(super) fn names<T: ValueEnum>() -> String {
    let named = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    named.map(|name| format!("\"{}\"", name.get_name())).collect::<Vec<_>>().join(" or ")
}
