//! Properties of the controller's parts over their whole range of input.

mod adaptation;
mod configuration;
mod dynamics;
mod observer;
mod path;
mod planner;
mod stop;
mod supervisor;
mod thresholds;
