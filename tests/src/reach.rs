//! Which functions a root may reach, by every call and jump in the machine code between a function's bounds, whether
//! a path leads there or not.

use std::collections::BTreeMap;

use crate::flow::{Flow, flow};
use crate::image::{Function, Image};

/// Functions that a root may reach, each with the one that it was first reached from.
pub struct Reach<'a> {
    image: &'a Image,
    callers: BTreeMap<u32, Option<u32>>,
}

impl<'a> Reach<'a> {
    /// Follows calls and tail calls from the functions at `roots`.
    ///
    /// # Errors
    /// A call or jump whose target the machine code does not tell, or that is no function's beginning.
    pub fn from(image: &'a Image, roots: &[u32]) -> Result<Self, String> {
        let mut callers: BTreeMap<_, _> = roots.iter().map(|root| (*root, None)).collect();
        let mut todo = roots.to_vec();
        while let Some(start) = todo.pop() {
            let function = image
                .functions
                .get(&start)
                .ok_or_else(|| format!("no function starts at {start:#x}"))?;
            for callee in callees(image, function)? {
                callers.entry(callee).or_insert_with(|| {
                    todo.push(callee);
                    Some(start)
                });
            }
        }
        Ok(Self { image, callers })
    }

    /// First addresses of all functions reached.
    pub fn functions(&self) -> impl Iterator<Item = u32> {
        self.callers.keys().copied()
    }

    /// Whether the instruction at `address` belongs to a function that is reached.
    pub fn contains(&self, address: u32) -> bool {
        self.image.function_at(address).is_some_and(|f| self.callers.contains_key(&f.start))
    }

    /// Ways from a root to each function that has a name which `is_meant`.
    pub fn ways_to(&self, is_meant: impl Fn(&str) -> bool) -> Vec<String> {
        let meant = self
            .image
            .symbols
            .iter()
            .filter(|(at, name)| self.callers.contains_key(at) && is_meant(name));
        meant.map(|(at, name)| format!("{} ({name})", self.way_to(*at))).collect()
    }

    fn way_to(&self, start: u32) -> String {
        let name = self.image.function_at(start).map_or("?", |f| &f.name);
        match self.callers.get(&start) {
            Some(Some(caller)) => format!("{} > {name}", self.way_to(*caller)),
            _ => name.to_owned(),
        }
    }
}

/// Functions that `function` calls or ends in.
fn callees(image: &Image, function: &Function) -> Result<Vec<u32>, String> {
    let body = function.start..function.end;
    let mut found = Vec::new();
    for (&at, insn) in image.code.range(body.clone()) {
        let targets = match flow(image, at, insn, false) {
            Flow::Call(callee) => vec![callee],
            Flow::Jump(to) => to,
            Flow::Either(to) => vec![to],
            Flow::CallRegister | Flow::JumpRegister => {
                return Err(format!("{} at {at:#x}: an unknown target", function.name));
            }
            Flow::Next | Flow::Return | Flow::Stop => vec![],
        };
        found.extend(targets.into_iter().filter(|target| !body.contains(target)));
    }
    Ok(found)
}
