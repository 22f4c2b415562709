//! What can be wrong with a scenario, each as one diagnostic.

use std::ops::Range;
use std::path::PathBuf;

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

/// Largest scenario file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 20;

/// Why a scenario could not be loaded.
#[derive(Debug, Diagnostic, Error)]
pub enum ScenarioError {
    /// The text breaks a rule at a known place.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Invalid(Box<Invalid>),
    /// Neither a shipped name nor a path.
    #[error("there is no scenario named `{name}`")]
    UnknownName {
        /// What was asked for.
        name: String,
        /// Shipped names and the likeliest of them.
        #[help]
        help: String,
    },
    /// A path without a file.
    #[error("there is no scenario file `{}`", path.display())]
    NotFound {
        /// What was asked for.
        path: PathBuf,
        /// Shipped names and the likeliest of them.
        #[help]
        help: String,
    },
    /// The file exists but could not be read.
    #[error("scenario file `{}` cannot be read: {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The operating system's answer.
        cause: std::io::Error,
    },
    /// The file is longer than [`MAX_BYTES`].
    #[error("scenario file `{}` is longer than 1 MiB", path.display())]
    #[diagnostic(help("a scenario takes a few hundred bytes: is this the right file?"))]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is not text.
    #[error("scenario file `{}` is not UTF-8 text: line {line} holds the byte 0x{byte:02x}", path.display())]
    #[diagnostic(help("save it as UTF-8, the only encoding of TOML"))]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Line of the first wrong byte, from 1.
        line: usize,
        /// The first wrong byte.
        byte: u8,
    },
}

/// One rule broken at one place of a scenario's text.
#[derive(Debug, Diagnostic, Error)]
#[error("{message}")]
pub struct Invalid {
    /// Field, value and what is wrong with it.
    pub message: String,
    /// File name and text.
    #[source_code]
    pub source_code: NamedSource<String>,
    /// Place of the offending value.
    #[label("{label}")]
    pub at: SourceSpan,
    /// What is allowed there.
    pub label: String,
    /// Why, where that is not obvious.
    #[help]
    pub help: Option<String>,
}

/// A scenario's text and the name that its errors give it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub name: &'a str,
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// What the file says in a span, cut to the end of its line.
    pub fn excerpt(&self, at: &Range<usize>) -> &'a str {
        let written = self.text.get(at.clone()).unwrap_or_default();
        written.lines().next().unwrap_or_default()
    }

    /// The same for a sentence: long values are cut.
    pub fn quoted(&self, at: &Range<usize>) -> String {
        const LONGEST: usize = 60;
        let written = self.excerpt(at);
        match written.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}...", &written[..end]),
            None => written.to_owned(),
        }
    }

    /// An error at a place; of a span of several lines only the first is marked.
    pub fn error(
        &self,
        at: &Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: &str,
    ) -> ScenarioError {
        ScenarioError::Invalid(Box::new(Invalid {
            message: message.into(),
            source_code: NamedSource::new(self.name, self.text.to_owned()),
            at: (at.start, self.excerpt(at).len()).into(),
            label: label.into(),
            help: (!help.is_empty()).then(|| help.to_owned()),
        }))
    }
}
