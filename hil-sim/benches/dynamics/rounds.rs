//! Interleaved timing: one pass of each contender a round.

use std::hint::black_box;
use std::time::Instant;

/// Enough that a median ignores the rounds that something else interrupted.
const ROUNDS: usize = 401;

/// One way of computing something from every state of a table.
pub struct Contender<'a> {
    states: usize,
    pass: Box<dyn FnMut() + 'a>,
}

impl<'a> Contender<'a> {
    /// `compute` sees each state as an unknown, and all that it returns counts as used.
    pub fn new<S, R>(states: &'a [S], mut compute: impl FnMut(&S) -> R + 'a) -> Self {
        let pass = move || {
            for state in states {
                black_box(compute(black_box(state)));
            }
        };
        Self { states: states.len(), pass: Box::new(pass) }
    }

    /// Mean time a state over one pass, ns.
    fn time_ns(&mut self) -> f64 {
        let start = Instant::now();
        (self.pass)();
        start.elapsed().as_secs_f64() * 1e9 / self.states as f64
    }
}

/// Median over the rounds of each contender's time a state, ns.
pub fn medians_ns<const N: usize>(mut contenders: [Contender<'_>; N]) -> [f64; N] {
    for contender in &mut contenders {
        contender.time_ns();
    }
    let mut times: [Vec<f64>; N] = core::array::from_fn(|_| Vec::with_capacity(ROUNDS));
    for _ in 0..ROUNDS {
        for (contender, times) in contenders.iter_mut().zip(&mut times) {
            times.push(contender.time_ns());
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    })
}
