//! Worst-case stack of an image, from its machine code: the depth at every instruction of every function, the calls
//! made there, and the exception frames. What cannot be bounded is refused with its function's name.

use std::collections::{BTreeMap, HashMap};

use crate::flow::{Flow, flow, stack_change};
use crate::image::{Function, Image};
use crate::it_block::{conditionals, epilogue_end};
use crate::thumb::Insn;

/// Largest exception frame, bytes: eight core words, S0 to S15, FPSCR and a reserved word (Armv7-M ARM, B1.5.7),
/// and one word that aligns it to eight bytes.
pub const EXCEPTION_FRAME_BYTES: u32 = 104 + 4;

/// Deepest path from one root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Stack that the root and its callees use, bytes, without an exception frame.
    pub bytes: u32,
    /// Function names from the root to the deepest callee.
    pub path: Vec<String>,
}

/// Targets of calls through registers, by the caller's name: what the machine code alone does not tell.
pub type IndirectCalls<'a> = &'a [(&'a str, &'a [&'a str])];

struct Frame {
    depth: u32,
    calls: BTreeMap<u32, u32>,
}

/// Bounds the stack from the function at `root`.
pub fn bound(image: &Image, root: u32, indirect: IndirectCalls) -> Result<Bound, String> {
    let mut walk = Walk { image, indirect, done: HashMap::new(), open: Vec::new() };
    walk.bound(root)
}

/// Bounds Reset and each exception of the vector table, by name.
pub fn bounds(image: &Image, indirect: IndirectCalls) -> Vec<(String, Result<Bound, String>)> {
    let name = |at| image.function_at(at).map_or(format!("{at:#x}"), |f| f.name.clone());
    image.vectors.iter().map(|&at| (name(at), bound(image, at, indirect))).collect()
}

/// Stack of thread code preempted by exceptions that nest in turn, bytes: each adds its frame.
pub fn nested_bytes(thread: &Bound, exceptions: &[&Bound]) -> u32 {
    thread.bytes + exceptions.iter().map(|e| e.bytes + EXCEPTION_FRAME_BYTES).sum::<u32>()
}

/// Start addresses of all functions that the one at `root` can reach, itself included.
pub fn reachable(image: &Image, root: u32, indirect: IndirectCalls) -> Result<Vec<u32>, String> {
    let mut walk = Walk { image, indirect, done: HashMap::new(), open: Vec::new() };
    walk.bound(root)?;
    let mut found: Vec<u32> = walk.done.into_keys().collect();
    found.sort_unstable();
    Ok(found)
}

struct Walk<'a> {
    image: &'a Image,
    indirect: IndirectCalls<'a>,
    done: HashMap<u32, Bound>,
    open: Vec<u32>,
}

impl Walk<'_> {
    fn bound(&mut self, start: u32) -> Result<Bound, String> {
        if let Some(known) = self.done.get(&start) {
            return Ok(known.clone());
        }
        let function = self
            .image
            .functions
            .get(&start)
            .ok_or_else(|| format!("no function starts at {start:#x}"))?;
        if self.open.contains(&start) {
            return Err(format!("{} is recursive", function.name));
        }
        self.open.push(start);
        let frame = self.frame(function)?;
        let mut worst = Bound { bytes: frame.depth, path: vec![function.name.clone()] };
        for (&callee, &depth) in &frame.calls {
            let below = self.bound(callee)?;
            if depth + below.bytes > worst.bytes {
                worst.bytes = depth + below.bytes;
                worst.path.truncate(1);
                worst.path.extend(below.path);
            }
        }
        self.open.pop();
        self.done.insert(start, worst.clone());
        Ok(worst)
    }

    /// Follows every path through one function with the stack's depth in bytes.
    fn frame(&self, function: &Function) -> Result<Frame, String> {
        let conditional = conditionals(self.image, function);
        let mut frame = Frame { depth: 0, calls: BTreeMap::new() };
        let mut seen = HashMap::new();
        let mut todo = vec![(function.start, 0)];
        while let Some((at, before)) = todo.pop() {
            match seen.insert(at, before) {
                Some(known) if known == before => continue,
                Some(_) => return refuse(function, at, "is reached with two stack depths"),
                None => {}
            }
            let Some(insn) = self.image.code.get(&at) else {
                return refuse(function, at, "is not code");
            };
            if let Some(end) = epilogue_end(self.image, &conditional, at, before) {
                todo.push((end, before));
                continue;
            }
            let is_conditional = conditional.contains_key(&at);
            let going = flow(self.image, at, insn, is_conditional);
            let depth = depth_after(function, at, insn, before, is_conditional, &going)?;
            frame.depth = frame.depth.max(depth);
            // A conditional return that does not happen has popped nothing.
            let kept = if going == Flow::Return { before } else { depth };
            let (inside, callees) = self.targets(function, at, insn, is_conditional, going)?;
            todo.extend(inside.into_iter().map(|target| (target, kept)));
            for callee in callees {
                let deepest = frame.calls.entry(callee).or_insert(0);
                *deepest = depth.max(*deepest);
            }
        }
        Ok(frame)
    }

    /// Where execution may go from `at` inside the function, and the functions that it may call or end in.
    fn targets(
        &self,
        function: &Function,
        at: u32,
        insn: &Insn,
        is_conditional: bool,
        going: Flow,
    ) -> Result<(Vec<u32>, Vec<u32>), String> {
        let next = at + insn.size();
        let is_inside = |target: &u32| (function.start..function.end).contains(target);
        // Past a call that does not come back the function ends, or its constants begin.
        let comes_back = is_inside(&next) && self.image.code.contains_key(&next);
        let (jumps, mut callees, goes_on) = match going {
            Flow::Next => (vec![], vec![], true),
            Flow::Jump(to) => (to, vec![], false),
            Flow::Either(to) => (vec![to], vec![], true),
            Flow::Call(callee) => (vec![], vec![callee], comes_back),
            Flow::CallRegister => (vec![], self.named_callees(function, at)?, comes_back),
            Flow::JumpRegister => (vec![], self.named_callees(function, at)?, is_conditional),
            Flow::Return => (vec![], vec![], is_conditional),
            Flow::Stop => (vec![], vec![], false),
        };
        let (mut inside, tail_calls): (Vec<u32>, Vec<u32>) = jumps.into_iter().partition(is_inside);
        callees.extend(tail_calls);
        if goes_on {
            inside.push(next);
        }
        let is_left = inside.iter().any(|t| !is_inside(t))
            || callees.iter().any(|c| !self.image.functions.contains_key(c));
        if is_left {
            return refuse(function, at, "leaves the function without a call");
        }
        Ok((inside, callees))
    }

    fn named_callees(&self, function: &Function, at: u32) -> Result<Vec<u32>, String> {
        let named = self.indirect.iter().find(|(caller, _)| function.name.contains(caller));
        let (_, callees) = named.ok_or_else(|| {
            format!("{} at {at:#x}: calls or jumps through a register", function.name)
        })?;
        callees.iter().map(|name| self.image.function_named(name).map(|f| f.start)).collect()
    }
}

fn refuse<T>(function: &Function, at: u32, why: &str) -> Result<T, String> {
    Err(format!("{} at {at:#x}: {why}", function.name))
}

/// Depth once `insn` is done, bytes.
fn depth_after(
    function: &Function,
    at: u32,
    insn: &Insn,
    before: u32,
    is_conditional: bool,
    going: &Flow,
) -> Result<u32, String> {
    let Some(change) = stack_change(insn) else {
        return refuse(function, at, "sets the stack pointer to a value not in the code");
    };
    if is_conditional && change != 0 && *going != Flow::Return {
        return refuse(function, at, "moves the stack pointer under a condition");
    }
    match before.checked_add_signed(change) {
        Some(1..) if *going == Flow::Return => {
            refuse(function, at, "returns before it has popped all")
        }
        Some(depth) => Ok(depth),
        None => refuse(function, at, "pops more than was pushed"),
    }
}
