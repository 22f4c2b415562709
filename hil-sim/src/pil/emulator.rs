//! The emulator as a child process, and the board's end of the bench over two FIFOs.

use std::cell::RefCell;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use std::time::Duration;

use firmware::executive::Retained;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{CWD, Mode, mkfifoat};
use shared::evidence::Image;
use shared::pil::{self, Release, TRANSFER_MAX};
use shared::telemetry::{RECORD_BYTES, Record};
use tempfile::TempDir;
use thiserror::Error;

use crate::bench::{Bench, Device, Output};
use crate::run::{ACCESS, Kept};

/// Program that emulates the board.
const PROGRAM: &str = "qemu-system-arm";
/// 8 ns an instruction: every tick rate leaves idle time between two ticks.
const ICOUNT: &str = "shift=3,align=off,sleep=off";
/// The emulator is looked after this often while it is silent.
const POLL: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };
/// Silence that counts as a hang: this many polls, 20 s.
const PATIENCE_POLLS: u32 = 100;

/// Why the emulator is of no use.
#[derive(Debug, Error)]
pub enum EmulatorError {
    /// No image.
    #[error("no board image at {path}; build it with `cargo firmware`")]
    NoImage {
        /// Where it was looked for.
        path: String,
    },
    /// The program is not there.
    #[error("cannot start {PROGRAM}: {0}; install it (Debian: apt-get install qemu-system-arm)")]
    Start(io::Error),
    /// The child ended.
    #[error("the emulator ended in the middle of the run ({0})")]
    Ended(String),
    /// The board's own code broke down.
    #[error(
        "the board took a hard fault (CFSR {status:#010x}): its stack overflowed, or the image has a defect"
    )]
    Fault {
        /// Fault status register.
        status: u32,
    },
    /// The child is silent.
    #[error("the emulator has been silent for 20 s")]
    Silent,
    /// The FIFOs failed.
    #[error("talking to the emulator failed: {0}")]
    Io(#[from] io::Error),
    /// The board sent what is no message.
    #[error("the board sent an unknown message (tag {0}); image and harness may differ in version")]
    Unknown(u8),
    /// The board refused its configuration.
    #[error("the board refuses its configuration")]
    Refused,
}

/// What the board leaves behind.
#[derive(Clone, Debug)]
pub struct End {
    /// High-water mark of its stack, bytes.
    pub stack_bytes: u16,
    /// What it kept.
    pub evidence: Box<Image>,
}

/// A running emulator; dropping it ends the process.
pub struct Emulator {
    child: Child,
    to_board: File,
    to_harness: Buffered,
    bench: Rc<RefCell<Bench>>,
    /// What the board is handed at each boot: configuration, its check sum, parked pose, access.
    introduction: Vec<u8>,
    coefficients: Vec<u8>,
    /// What the board has said on the operator link.
    said: Vec<u8>,
    /// Holds the FIFOs; removed at the end.
    _folder: TempDir,
}

impl Emulator {
    /// Starts `image` and hands it its configuration.
    ///
    /// # Errors
    /// [`EmulatorError`] where it does not come up.
    pub fn start(
        image: &Path,
        kept: impl Into<Kept>,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
    ) -> Result<Self, EmulatorError> {
        Self::start_with(image, kept, retained, bench, &[])
    }

    /// As [`Self::start`], with further arguments to the emulator.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_with(
        image: &Path,
        kept: impl Into<Kept>,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
        arguments: &[String],
    ) -> Result<Self, EmulatorError> {
        let mut emulator = Self::spawn(image, kept.into(), retained, bench, arguments)?;
        emulator.introduce()?;
        Ok(emulator)
    }

    /// Starts the process; the board has not been handed anything.
    pub(super) fn spawn(
        image: &Path,
        Kept { config, crc }: Kept,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
        arguments: &[String],
    ) -> Result<Self, EmulatorError> {
        let image = image
            .canonicalize()
            .map_err(|_| EmulatorError::NoImage { path: image.display().to_string() })?;
        let folder = tempfile::tempdir()?;
        let [to_board, to_harness] =
            [pil::TO_BOARD, pil::TO_HARNESS].map(|n| folder.path().join(n));
        for fifo in [&to_board, &to_harness] {
            mkfifoat(CWD, fifo, Mode::RUSR | Mode::WUSR).map_err(io::Error::from)?;
        }
        // Opened for both directions, a FIFO never blocks on a missing peer.
        let open = |path| OpenOptions::new().read(true).write(true).open(path);
        let (to_board, to_harness) = (open(&to_board)?, open(&to_harness)?);
        let child =
            command(&image, folder.path(), arguments).spawn().map_err(EmulatorError::Start)?;
        let mut introduction = bytemuck::bytes_of(&config).to_vec();
        introduction.extend(crc.to_le_bytes());
        introduction
            .extend(retained.parked.unwrap_or_default().map(u32::to_le_bytes).as_flattened());
        introduction.extend(ACCESS.boots.to_le_bytes());
        introduction.extend(ACCESS.key);
        Ok(Self {
            child,
            to_board,
            to_harness: Buffered::new(to_harness),
            bench,
            introduction,
            coefficients: Vec::new(),
            said: Vec::new(),
            _folder: folder,
        })
    }

    /// Hands the board its configuration, after power-up or after it has reset itself.
    ///
    /// # Errors
    /// [`EmulatorError`] where it does not come up.
    pub fn introduce(&mut self) -> Result<(), EmulatorError> {
        self.forget_unread()?;
        self.to_board.write_all(&self.introduction)?;
        self.coefficients = self.greet()?;
        Ok(())
    }

    /// Takes back what the board has not read: meant for one that is gone.
    fn forget_unread(&mut self) -> Result<(), EmulatorError> {
        let mut unread = [0; 256];
        while poll(&mut [PollFd::new(&self.to_board, PollFlags::IN)], Some(&Timespec::default()))
            .map_err(io::Error::from)?
            > 0
        {
            let _ = self.to_board.read(&mut unread)?;
        }
        Ok(())
    }

    /// What the configuration became on the board.
    pub fn coefficients(&self) -> &[u8] {
        &self.coefficients
    }

    /// The emulator's process.
    pub fn process_id(&self) -> u32 {
        self.child.id()
    }

    /// Ends the emulation in order, so that what the emulator writes at its end is written.
    ///
    /// # Errors
    /// Where it cannot be told or does not end.
    pub fn stop(mut self) -> Result<End, EmulatorError> {
        self.release(&Release::instead(pil::QUIT))?;
        let stack_bytes = match self.byte()? {
            pil::TAG_STACK => u16::from_le_bytes([self.byte()?, self.byte()?]),
            tag => return Err(self.unexpected(tag)),
        };
        let mut evidence: Box<Image> = Box::new(bytemuck::zeroed());
        self.fill(bytemuck::bytes_of_mut(&mut *evidence))?;
        for _ in 0..PATIENCE_POLLS {
            if self.child.try_wait()?.is_some() {
                return Ok(End { stack_bytes, evidence });
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Err(EmulatorError::Silent)
    }

    fn greet(&mut self) -> Result<Vec<u8>, EmulatorError> {
        match self.byte()? {
            pil::TAG_COEFFICIENTS => {
                let length = u16::from_le_bytes([self.byte()?, self.byte()?]);
                (0..length).map(|_| self.byte()).collect()
            }
            pil::TAG_REFUSED => Err(EmulatorError::Refused),
            tag => Err(self.unexpected(tag)),
        }
    }

    /// What a message means that may come at any time, or at none.
    fn unexpected(&mut self, tag: u8) -> EmulatorError {
        let mut status = [0; 4];
        match tag {
            pil::TAG_FAULT => match self.fill(&mut status) {
                Ok(()) => EmulatorError::Fault { status: u32::from_le_bytes(status) },
                Err(error) => error,
            },
            _ => EmulatorError::Unknown(tag),
        }
    }

    /// What the board has said on the operator link since this was last asked.
    pub fn said(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.said)
    }

    /// Releases one tick and serves its bus until its record arrives.
    ///
    /// # Errors
    /// [`EmulatorError`] where the emulator is gone or talks nonsense.
    pub fn exchange(&mut self, release: &Release) -> Result<Record, EmulatorError> {
        self.release(release)?;
        self.serve()
    }

    pub(super) fn release(&mut self, release: &Release) -> Result<(), EmulatorError> {
        Ok(self.to_board.write_all(bytemuck::bytes_of(release))?)
    }

    /// Makes the board pass through its function `halt`.
    pub(super) fn halt(&mut self) -> Result<(), EmulatorError> {
        self.release(&Release::instead(pil::HALT))
    }

    /// Serves the bus until the record arrives.
    pub(super) fn serve(&mut self) -> Result<Record, EmulatorError> {
        loop {
            match self.byte()? {
                pil::TAG_PIN => {
                    let (pin, high) = (self.byte()?, self.byte()? != 0);
                    let pin = Output::from_number(pin).ok_or(EmulatorError::Unknown(pin))?;
                    self.bench.borrow_mut().set(pin, high);
                }
                pil::TAG_TRANSFER => self.transfer()?,
                pil::TAG_LINK => {
                    let length = self.byte()?;
                    for _ in 0..length {
                        let byte = self.byte()?;
                        self.said.push(byte);
                    }
                }
                pil::TAG_RECORD => {
                    let mut bytes = [0; RECORD_BYTES];
                    self.fill(&mut bytes)?;
                    return Ok(Record::from_bytes(&bytes));
                }
                tag => return Err(self.unexpected(tag)),
            }
        }
    }

    fn transfer(&mut self) -> Result<(), EmulatorError> {
        let (device, length) = (self.byte()?, self.byte()?);
        let device = Device::from_number(device).ok_or(EmulatorError::Unknown(device))?;
        let (mut mosi, mut answer) = ([0; TRANSFER_MAX], [0; 1 + TRANSFER_MAX]);
        let length = usize::from(length).min(TRANSFER_MAX);
        self.fill(&mut mosi[..length])?;
        let miso = &mut answer[1..=length];
        let exchanged = self.bench.borrow_mut().transfer(device, &mosi[..length], miso);
        answer[0] = u8::from(exchanged.is_err());
        Ok(self.to_board.write_all(&answer[..=length])?)
    }

    fn byte(&mut self) -> Result<u8, EmulatorError> {
        let mut byte = [0];
        self.fill(&mut byte)?;
        Ok(byte[0])
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), EmulatorError> {
        let mut done = 0;
        while done < bytes.len() {
            let taken = self.to_harness.take(&mut bytes[done..]);
            if taken == 0 {
                self.refill()?;
            }
            done += taken;
        }
        Ok(())
    }

    /// Waits for bytes from the board, watching the child.
    fn refill(&mut self) -> Result<(), EmulatorError> {
        for _ in 0..PATIENCE_POLLS {
            let mut wanted = [PollFd::new(&self.to_harness.file, PollFlags::IN)];
            match poll(&mut wanted, Some(&POLL)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => {}
                Ok(_) => return Ok(self.to_harness.refill()?),
                Err(error) => return Err(io::Error::from(error).into()),
            }
            if let Some(status) = self.child.try_wait()? {
                return Err(EmulatorError::Ended(status.to_string()));
            }
        }
        Err(EmulatorError::Silent)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // An error here means that it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn command(image: &Path, folder: &Path, arguments: &[String]) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "null"])
        .args(["-semihosting-config", "enable=on,target=native", "-icount", ICOUNT])
        .args(arguments)
        .arg("-kernel")
        .arg(image)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::inherit());
    command
}

/// A FIFO's reading end with a buffer that never asks for more than has arrived.
struct Buffered {
    file: File,
    bytes: [u8; 1024],
    range: std::ops::Range<usize>,
}

impl Buffered {
    fn new(file: File) -> Self {
        Self { file, bytes: [0; 1024], range: 0..0 }
    }

    fn take(&mut self, wanted: &mut [u8]) -> usize {
        let taken = wanted.len().min(self.range.len());
        wanted[..taken].copy_from_slice(&self.bytes[self.range.start..self.range.start + taken]);
        self.range.start += taken;
        taken
    }

    fn refill(&mut self) -> io::Result<()> {
        self.range = 0..self.file.read(&mut self.bytes)?;
        Ok(())
    }
}
