//! Run folder: summary.json, log.csv and report.html.
