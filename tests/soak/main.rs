//! Long runs over a bus that errs: what is sound trips nothing, what is not is stopped every time.

mod random;
mod scenarios;
