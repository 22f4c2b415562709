//! The emulator's debugging port: stops the board at a function and changes its registers, so that an image can be
//! broken that has nothing built in for it (GDB remote serial protocol).

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// The emulator opens its port, and answers, within this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// A connection to a board that stands still.
pub(super) struct Debugger {
    port: UnixStream,
}

impl Debugger {
    /// Connects to the port at `path`, as soon as there is one.
    pub fn connect(path: &Path) -> io::Result<Self> {
        let started = Instant::now();
        let port = loop {
            match UnixStream::connect(path) {
                Ok(port) => break port,
                Err(error) if started.elapsed() > PATIENCE => return Err(error),
                Err(_) => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        port.set_read_timeout(Some(PATIENCE))?;
        let mut debugger = Self { port };
        // Registers can be written one by one only once their description was read.
        debugger.ask("qXfer:features:read:target.xml:0,ff")?;
        Ok(debugger)
    }

    /// Makes the board stop at `address`: code that runs often takes much longer then.
    pub fn set_breakpoint(&mut self, address: u32) -> io::Result<()> {
        self.order(&format!("Z0,{address:x},2"))
    }

    /// Takes the breakpoint away.
    pub fn clear_breakpoint(&mut self, address: u32) -> io::Result<()> {
        self.order(&format!("z0,{address:x},2"))
    }

    /// Sets a core register: 13 is the stack pointer, 15 the program counter.
    pub fn set_register(&mut self, number: u8, value: u32) -> io::Result<()> {
        self.order(&format!("P{number:x}={:08x}", value.swap_bytes()))
    }

    /// Lets the board go on, but not from a breakpoint: it would stop there again. Nothing may be sent until it has
    /// stopped.
    pub fn go_on(&mut self) -> io::Result<()> {
        self.send("c")
    }

    /// Waits until the board has stopped.
    pub fn await_stop(&mut self) -> io::Result<()> {
        let answer = self.receive()?;
        if answer.starts_with('T') { Ok(()) } else { Err(unexpected(&answer)) }
    }

    fn order(&mut self, order: &str) -> io::Result<()> {
        let answer = self.ask(order)?;
        if answer == "OK" { Ok(()) } else { Err(unexpected(&answer)) }
    }

    fn ask(&mut self, question: &str) -> io::Result<String> {
        self.send(question)?;
        self.receive()
    }

    /// Sends a packet: `$`, text, `#`, sum of the text's bytes.
    fn send(&mut self, text: &str) -> io::Result<()> {
        let sum = text.bytes().fold(0_u8, u8::wrapping_add);
        self.port.write_all(format!("${text}#{sum:02x}").as_bytes())?;
        match self.byte()? {
            b'+' => Ok(()),
            other => Err(unexpected(&char::from(other).to_string())),
        }
    }

    /// Takes a packet's text and acknowledges it.
    fn receive(&mut self) -> io::Result<String> {
        while self.byte()? != b'$' {}
        let mut text = String::new();
        loop {
            match self.byte()? {
                b'#' => break,
                byte => text.push(byte.into()),
            }
        }
        // The port is a local one: its check sum has nothing to find.
        for _ in 0..2 {
            self.byte()?;
        }
        self.port.write_all(b"+")?;
        Ok(text)
    }

    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.port.read_exact(&mut byte)?;
        Ok(byte[0])
    }
}

fn unexpected(answer: &str) -> io::Error {
    io::Error::other(format!("the emulator's debugging port answered `{answer}`"))
}
