//! The scenario parser.

use hil_sim::scenario::Scenario;

/// Any text is a scenario or an error that names its file.
pub fn scenario(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(error) = Scenario::parse("fuzzed.toml", &text) {
        let error = miette::Report::new(error);
        assert!(!format!("{error}").is_empty() && format!("{error:?}").contains("fuzzed.toml"));
    }
}
