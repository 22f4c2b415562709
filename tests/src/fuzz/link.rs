//! The board's end of the operator link.

use firmware::config::Config;
use firmware::link::{Access, Station};
use firmware::planner::Order;
use hil_sim::console::{Console, KEY, Line};
use shared::link::Kind;

/// A board with an operator in session.
pub struct Board {
    /// Its end of the link.
    pub station: Station,
    /// The line.
    pub line: Line,
    /// The operator.
    pub console: Console,
}

impl Board {
    /// In session.
    ///
    /// # Panics
    /// If the session does not come about.
    pub fn new() -> Self {
        let mut station = Station::new();
        station.configure(&Config::default(), &Access { key: KEY, boots: 1 });
        let console = Console::new(KEY, [7; 16], 2_000);
        let mut board = Self { station, line: Line::default(), console };
        let hello = board.console.hello();
        board.serve(&hello.to_wire());
        assert!(board.console.is_in_session());
        let heartbeat = board.console.heartbeat();
        assert!(board.serve(&heartbeat.to_wire()).alive);
        board
    }

    /// Takes these bytes and whatever tick they lead to.
    pub fn serve(&mut self, bytes: &[u8]) -> Effect {
        self.line.deliver(bytes);
        let mut effect = Effect::default();
        loop {
            self.station.serve(&mut self.line, &());
            let served = self.station.served();
            let order = served.order().copied();
            effect.alive |= served.alive;
            effect.orders.extend(order);
            self.station.taken(0);
            if order.is_none() && self.line.is_silent() {
                break;
            }
        }
        self.console.hear(&self.line.take());
        effect
    }
}

impl Default for Board {
    fn default() -> Self {
        Self::new()
    }
}

/// What bytes on the link led to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effect {
    /// The operator counts as present.
    pub alive: bool,
    /// Orders to the tick.
    pub orders: Vec<Order>,
}

/// Any bytes: without the key nothing but a stop comes of them, and the operator is heard as before.
pub fn link(bytes: &[u8]) {
    let mut board = Board::new();
    let effect = board.serve(bytes);
    assert!(!effect.alive && effect.orders.iter().all(|order| *order == Order::Stop));
    // The zero at its start ends what came before.
    let stop = board.serve(&Console::stop().to_wire());
    assert_eq!((stop.alive, stop.orders), (false, vec![Order::Stop]));
    let heartbeat = board.console.next(Kind::Heartbeat, [0; 40]);
    assert_eq!(board.serve(&heartbeat.to_wire()), Effect { alive: true, orders: Vec::new() });
}
