//! The emulator as a child process, and the two FIFOs that its board talks through.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{CWD, Mode, mkfifoat};
use shared::pil;
use tempfile::TempDir;
use thiserror::Error;

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

/// A running emulator; dropping it ends the process.
pub struct Process {
    child: Child,
    to_board: File,
    to_harness: Buffered,
    /// Holds the FIFOs; removed at the end.
    _folder: TempDir,
}

impl Process {
    /// Starts `image` with further arguments to the emulator.
    ///
    /// # Errors
    /// Where there is no image or no emulator.
    pub fn start(image: &Path, arguments: &[String]) -> Result<Self, EmulatorError> {
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
        Ok(Self { child, to_board, to_harness: Buffered::new(to_harness), _folder: folder })
    }

    /// Its number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// Where that does not come.
    pub fn wait(&mut self) -> Result<(), EmulatorError> {
        for _ in 0..PATIENCE_POLLS {
            if self.child.try_wait()?.is_some() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Err(EmulatorError::Silent)
    }

    /// Sends bytes to the board.
    ///
    /// # Errors
    /// Where its FIFO takes none.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        Ok(self.to_board.write_all(bytes)?)
    }

    /// Takes back what the board has not read: meant for one that is gone.
    ///
    /// # Errors
    /// Where the FIFO fails.
    pub fn forget_unread(&mut self) -> Result<(), EmulatorError> {
        let mut unread = [0; 256];
        while poll(&mut [PollFd::new(&self.to_board, PollFlags::IN)], Some(&Timespec::default()))
            .map_err(io::Error::from)?
            > 0
        {
            let _ = self.to_board.read(&mut unread)?;
        }
        Ok(())
    }

    /// The next byte from the board.
    ///
    /// # Errors
    /// Where none comes.
    pub fn byte(&mut self) -> Result<u8, EmulatorError> {
        let mut byte = [0];
        self.fill(&mut byte)?;
        Ok(byte[0])
    }

    /// The next bytes from the board.
    ///
    /// # Errors
    /// Where they do not come.
    pub fn fill(&mut self, bytes: &mut [u8]) -> Result<(), EmulatorError> {
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

impl Drop for Process {
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
