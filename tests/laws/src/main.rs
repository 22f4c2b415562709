//! The firmware's law and its plain versions on the emulated board. Each runs over the same states under its own
//! symbol, so that its cycles can be counted, and their results are compared.
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "the entry point's symbol")]

mod states;

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use firmware::JointVector;
use firmware::config::{Config, Law};
use firmware::dynamics::Constants;
use firmware::law::{self, Coefficients};
use firmware::math::clamp_symmetric;
use plain::{Adaptation, Command, Gains, Model, State};
use shared::arm::REFERENCE;
use states::States;

/// States under each adaptation.
const STATES: u32 = 32;

/// Largest error allowed, of the largest number in the row.
const TOLERANCE: f32 = 1e-3;

static CONFIG: Config = Config::for_arm(&REFERENCE, 2_000);

/// What the firmware's tick keeps for its law.
struct Ours {
    law: Coefficients,
    dynamics: Constants,
    tau_max: JointVector,
}

/// The law with its dynamics, the torque limits and one step of adaptation.
#[inline(never)]
fn ours(c: &Ours, s: &law::State, d_hat: &JointVector) -> Command {
    let wanted = law::evaluate(&c.law, &c.dynamics, s, d_hat);
    Command {
        torque: wanted.torque.zip_map(&c.tau_max, clamp_symmetric),
        d_hat: law::adapt(&c.law, d_hat, &wanted.adaptation),
    }
}

#[inline(never)]
fn plain_crba(model: &Model, gains: &Gains, s: &State, d_hat: &JointVector) -> Command {
    plain::control_by_crba(model, gains, s, d_hat)
}

#[inline(never)]
fn plain_five_calls(model: &Model, gains: &Gains, s: &State, d_hat: &JointVector) -> Command {
    plain::control_by_five_calls(model, gains, s, d_hat)
}

/// Outcome of all comparisons of two numbers.
#[derive(Default)]
struct Agreement {
    agreeing: u32,
    compared: u32,
    /// Largest error of those that agree, of the largest number in the row.
    worst: f32,
}

impl Agreement {
    fn compare(&mut self, got: &Command, want: &Command) {
        self.rows(&got.torque, &want.torque);
        self.rows(&got.d_hat, &want.d_hat);
    }

    fn rows(&mut self, got: &JointVector, want: &JointVector) {
        let scale = want.amax();
        for error in (got - want).abs().iter().map(|e| e / scale) {
            self.compared += 1;
            // A NaN agrees with nothing.
            if error <= TOLERANCE {
                self.agreeing += 1;
                self.worst = if error > self.worst { error } else { self.worst };
            }
        }
    }
}

#[entry]
fn main() -> ! {
    let model = Model::new(&REFERENCE);
    let mut agreement = Agreement::default();
    for law in [Law::INERTIA_WEIGHTED, Law::PAPER_PSI] {
        run(law, &model, &mut agreement);
    }
    let Agreement { agreeing, compared, worst } = agreement;
    hprintln!("agreeing {}", agreeing);
    hprintln!("compared {}", compared);
    hprintln!("worst {:e}", worst);
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// All three over all states. What they are handed is hidden from the compiler, which would else fold it into them.
#[inline(never)]
fn run(law: Law, model: &Model, agreement: &mut Agreement) {
    let config = black_box(&CONFIG);
    let tau_max = config.joints.map(|j| j.tau_max).into();
    let gains = plain_gains(law, tau_max);
    let law =
        Coefficients::new(&firmware::config::Gains { law, ..config.gains }, config.tick_hz as f32);
    let controller = Ours { law, dynamics: Constants::new(&config.arm), tau_max };
    let mut states = States::new(config);
    for n in 0..STATES {
        let s = states.state();
        // From zero the step itself is compared, from elsewhere its sum too.
        let d_hat = if n % 2 == 0 { JointVector::zeros() } else { states.d_hat() };
        let mine = law::State { q: s.q, qd: s.qd, e1: s.e1, e1_dot: s.e1_dot, qdd_d: s.qdd_d };
        let want = ours(black_box(&controller), black_box(&mine), black_box(&d_hat));
        for plain in [plain_crba, plain_five_calls] {
            let got = plain(black_box(model), black_box(&gains), black_box(&s), black_box(&d_hat));
            agreement.compare(&got, &want);
        }
    }
}

fn plain_gains(law: Law, tau_max: JointVector) -> Gains {
    let gains = &CONFIG.gains;
    Gains {
        k1: gains.k1.into(),
        k2: gains.k2.into(),
        adaptation: match law {
            Law::PAPER_PSI => Adaptation::PaperPsi(gains.psi.into()),
            _ => Adaptation::InertiaWeighted(gains.wa_rad_s),
        },
        d_max: gains.d_max.into(),
        tau_max,
        tick_s: 1.0 / CONFIG.tick_hz as f32,
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}
