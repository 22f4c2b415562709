//! Proofs on the images of both boards, from their machine code and symbols; each beside an image that fails it.

mod arithmetic;
mod linkage;
mod sizes;
mod stack;

/// The emulated board and the real one.
const BOARDS: [&str; 2] = ["mps2-an386", "nucleo-f446re"];
