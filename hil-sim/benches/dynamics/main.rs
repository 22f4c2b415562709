//! `cargo bench`: the closed form against a general library, and the law against plain recursions.
//!
//! All contenders of a comparison take turns on the same random states, so a change of clock or load
//! meets them alike. `dynibo` computes in `f64`, which is all it offers; everything else in `f32`. Its
//! gravity is fixed at 9.80665 m/s², so in that comparison the closed form uses it too.

mod peer;
mod rounds;
mod samples;

use std::hint::black_box;

use firmware::JointVector;
use firmware::config::{ArmModel, Config, Law};
use firmware::dynamics::Constants;
use firmware::law::{self, Coefficients};
use firmware::math::clamp_symmetric;
use plain::{Adaptation, Gains, Model};
use shared::arm::REFERENCE;

use peer::Peer;
use rounds::{Contender, medians_ns};
use samples::Samples;

fn main() {
    let samples = Samples::random();
    println!("median ns a state; dynibo in f64, all else in f32");
    let config = Config::default();
    compare_laws("inertia-weighted law", &config, &samples);
    let mut config = config;
    config.gains.law = Law::PAPER_PSI;
    compare_laws("law with the paper's psi", &config, &samples);
    compare_dynamics(&samples);
}

/// M, and C qd + G, of the reference arm: the closed form and the library.
fn compare_dynamics(samples: &Samples) {
    let mut peer = Peer::new(&REFERENCE);
    let arm = ArmModel { gravity_m_s2: peer::GRAVITY_M_S2 as f32, ..Config::default().arm };
    let constants = black_box(Constants::new(&arm));
    peer.must_agree_with_reference();
    peer.must_agree_with(&constants, samples);

    let [ours, library] = medians_ns([
        Contender::new(&samples.firmware, |s| {
            let terms = constants.at(&s.q);
            (terms.inertia_matrix(), terms.coriolis(&s.qd) + terms.gravity())
        }),
        Contender::new(&samples.exact, |s| {
            peer.compute(&s.q, &s.qd);
            black_box(&peer.mass);
            black_box(&peer.bias);
        }),
    ]);
    println!(
        "M + C qd + G: ours {ours:.1} ns, dynibo {library:.1} ns, ratio {:.1}",
        library / ours
    );
}

/// Torque and next estimate of one tick: the firmware's law and its two plain versions.
fn compare_laws(name: &str, config: &Config, samples: &Samples) {
    let d_hat = black_box(JointVector::zeros());
    let constants = black_box(Constants::new(&config.arm));
    let coefficients = black_box(Coefficients::new(&config.gains, config.tick_hz as f32));
    let gains = black_box(plain_gains(config));
    let model = black_box(Model::new(&REFERENCE));

    let [ours, crba, five] = medians_ns([
        Contender::new(&samples.firmware, |s| {
            let wanted = law::evaluate(&coefficients, &constants, s, &d_hat);
            let next = law::adapt(&coefficients, &d_hat, &wanted.adaptation);
            (wanted.torque.zip_map(&gains.tau_max, clamp_symmetric), next)
        }),
        Contender::new(&samples.plain, |s| plain::control_by_crba(&model, &gains, s, &d_hat)),
        Contender::new(&samples.plain, |s| plain::control_by_five_calls(&model, &gains, s, &d_hat)),
    ]);
    println!(
        "{name}: ours {ours:.1} ns, CRBA + RNEA {crba:.1} ns, ratio {:.1}, \
         five RNEA calls {five:.1} ns, ratio {:.1}",
        crba / ours,
        five / ours
    );
}

fn plain_gains(config: &Config) -> Gains {
    Gains {
        k1: config.gains.k1.into(),
        k2: config.gains.k2.into(),
        adaptation: match config.gains.law {
            Law::PAPER_PSI => Adaptation::PaperPsi(config.gains.psi.into()),
            _ => Adaptation::InertiaWeighted(config.gains.wa_rad_s),
        },
        d_max: config.gains.d_max.into(),
        tau_max: config.joints.map(|j| j.tau_max).into(),
        tick_s: 1.0 / config.tick_hz as f32,
    }
}
