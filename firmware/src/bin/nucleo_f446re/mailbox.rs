//! What the operator's end hands to the next tick, and what that tick makes of it.

use core::cell::Cell;

use cortex_m::interrupt::{self, Mutex};
use firmware::link::{Served, Station};

#[derive(Clone, Copy)]
enum Mail {
    Empty,
    /// For the next tick.
    Posted(Served),
    /// A tick took it; its record names this refusal.
    Taken(u8),
}

static MAIL: Mutex<Cell<Mail>> = Mutex::new(Cell::new(Mail::Empty));

/// Whether the station is idle's to use: no tick has yet to take what it has served. Tells it what the last one made
/// of it.
pub fn returned(station: &mut Station) -> bool {
    let mail = interrupt::free(|section| {
        let mail = MAIL.borrow(section);
        let was = mail.get();
        if matches!(was, Mail::Taken(_)) {
            mail.set(Mail::Empty);
        }
        was
    });
    if let Mail::Taken(refusal) = mail {
        station.taken(refusal);
    }
    !matches!(mail, Mail::Posted(_))
}

/// Hands on what has been served, if it is anything.
pub fn post(served: &Served) {
    if served.alive || served.order().is_some() {
        interrupt::free(|section| MAIL.borrow(section).set(Mail::Posted(*served)));
    }
}

/// The tick's: what idle has posted. Has to be answered.
pub fn take() -> Option<Served> {
    interrupt::free(|section| match MAIL.borrow(section).get() {
        Mail::Posted(served) => Some(served),
        _ => None,
    })
}

/// The tick's verdict on what it took.
pub fn answer(refusal: u8) {
    interrupt::free(|section| MAIL.borrow(section).set(Mail::Taken(refusal)));
}
