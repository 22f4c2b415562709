//! Sessions: whose frames count, and which of them are new.
//!
//! A Hello only opens a candidate; its first authentic frame makes it the current session. So a repeated Hello, which
//! anyone can send who has recorded one, cannot throw the operator out.

use shared::fault::LinkRefusal;
use shared::link::{DEFAULT_KEY, Frame, Key, Welcome, session_message};

use super::code::{hmac, is_coded};

/// Who may command the board, and what makes its sessions unique.
#[derive(Clone, Copy, Debug)]
pub struct Access {
    /// The operator's key.
    pub key: Key,
    /// Boots of the board so far. The board has no random source: no two boots may share this number.
    pub boots: u32,
}

#[derive(Clone, Copy, Debug)]
struct Session {
    key: Key,
    /// Counter of its last frame that was taken.
    last: u32,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Sessions {
    access: Access,
    hellos: u32,
    current: Option<Session>,
    candidate: Option<Session>,
}

impl Sessions {
    /// There is none yet, and nobody may open one.
    pub const NONE: Self = Self {
        access: Access { key: DEFAULT_KEY, boots: 0 },
        hellos: 0,
        current: None,
        candidate: None,
    };

    /// Says who may command.
    pub fn set(&mut self, access: &Access) {
        self.access = *access;
    }

    /// Whether anybody could have the operator's key.
    pub fn has_default_key(&self) -> bool {
        self.access.key == DEFAULT_KEY
    }

    /// Whether a session may be opened: the Hello's code is right, and the nonce would not come twice.
    ///
    /// # Errors
    /// Why not.
    #[inline(never)]
    pub fn open(&mut self, frame: &Frame) -> Result<(), LinkRefusal> {
        if !is_coded(&self.access.key, frame) {
            return Err(LinkRefusal::BadCode);
        }
        self.hellos = self.hellos.checked_add(1).ok_or(LinkRefusal::SessionsUsedUp)?;
        Ok(())
    }

    /// The answer to the Hello that was just taken.
    #[inline(never)]
    pub fn welcome(&mut self, challenge: [u8; 16]) -> Welcome {
        let (boots, hellos) = (self.access.boots, self.hellos);
        let key = hmac(&self.access.key, &session_message(challenge, boots, hellos));
        self.candidate = Some(Session { key, last: 0 });
        Welcome { challenge, boots, hellos, reserved: [0; 16] }
    }

    /// Whether `frame` is the operator's and new; makes the candidate current if it is that one's.
    ///
    /// # Errors
    /// Why it is not.
    #[inline(never)]
    pub fn admit(&mut self, frame: &Frame) -> Result<(), LinkRefusal> {
        if self.current.is_none() && self.candidate.is_none() {
            return Err(LinkRefusal::NoSession);
        }
        let is_its = |session: &&mut Session| is_coded(&session.key, frame);
        if let Some(session) = self.current.as_mut().filter(is_its) {
            return session.take(frame.counter);
        }
        let Some(session) = self.candidate.as_mut().filter(is_its) else {
            return Err(LinkRefusal::BadCode);
        };
        session.take(frame.counter)?;
        self.current = self.candidate.take();
        Ok(())
    }

    /// Key for what the board sends: a Welcome goes to the candidate, all else to the current session.
    pub fn key(&self, welcome: bool) -> &Key {
        let session = if welcome { &self.candidate } else { &self.current };
        session.as_ref().map_or(&self.access.key, |session| &session.key)
    }
}

impl Session {
    fn take(&mut self, counter: u32) -> Result<(), LinkRefusal> {
        if counter <= self.last {
            return Err(LinkRefusal::Stale);
        }
        self.last = counter;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use shared::link::Kind;

    use super::super::code::sign;
    use super::*;

    /// As they would begin anew, recorded frames of the first would count again.
    #[test]
    fn the_last_session_of_a_boot_is_followed_by_none() {
        let mut sessions = Sessions { hellos: u32::MAX - 1, ..Sessions::NONE };
        let mut hello: Frame = bytemuck::zeroed();
        hello.begin(Kind::Hello, 0);
        sign(&DEFAULT_KEY, &mut hello);
        assert_eq!(sessions.open(&hello), Ok(()));
        assert_eq!(sessions.welcome([1; 16]).hellos, u32::MAX);
        assert_eq!([(); 2].map(|()| sessions.open(&hello)), [Err(LinkRefusal::SessionsUsedUp); 2]);
    }
}
