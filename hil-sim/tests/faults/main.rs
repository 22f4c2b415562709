//! Injected faults reach the controller and the arm where, when and as they should.

mod hardware;
mod injection;
mod rig;
mod timing;
