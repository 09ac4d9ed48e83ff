//! Rows of a benchmark in a file that is written anew after every row.

use crate::console;
use anyhow::{Context, Result, bail};
use fovolnet::io::atomic;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::Write;
use std::path::PathBuf;

/// One measurement.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    pub what: String,
    /// Prediction of the model, where it knows the GPU.
    pub predicted: Option<f64>,
    pub measured: f64,
    pub unit: String,
    /// Whether the result is that of the reference; `None` where there is none.
    pub equal: Option<bool>,
}

/// All rows so far, and their file.
#[derive(Serialize, Deserialize)]
pub struct Record {
    adapter: String,
    rows: Vec<Row>,
    #[serde(skip)]
    path: PathBuf,
}

/// Factor by which a measurement may miss its prediction.
const NEAR: f64 = 1.5;

impl Record {
    /// Record of `adapter` in the file `path`, whose rows are kept with `resume`.
    ///
    /// # Errors
    /// A file that is none of ours, or of another adapter, to resume.
    pub fn new(path: PathBuf, adapter: String, resume: bool) -> Result<Self> {
        if !(resume && path.exists()) {
            return Ok(Self { adapter, rows: Vec::new(), path });
        }
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let kept: Self = serde_json::from_str(&text)
            .with_context(|| format!("{} is no file of bench gpu; leave out --resume", path.display()))?;
        if kept.adapter != adapter {
            bail!("{} is of {}, this is {adapter}; write another file", path.display(), kept.adapter);
        }
        Ok(Self { path, ..kept })
    }

    /// Whether there is a row for `what`.
    pub fn has(&self, what: &str) -> bool {
        self.rows.iter().any(|row| row.what == what)
    }

    /// Says and keeps `row`.
    pub fn add(&mut self, row: Row) -> Result<()> {
        if self.has(&row.what) {
            return Ok(());
        }
        console::say(line(&row))?;
        self.rows.push(row);
        let text = serde_json::to_string_pretty(&self).context("the rows cannot be written as JSON")?;
        Ok(atomic::write(&self.path, |out| writeln!(out, "{text}"))?)
    }

    /// Says which rows are not as predicted, or not equal.
    ///
    /// # Errors
    /// Rows that are not equal.
    pub fn conclude(&self) -> Result<()> {
        let misses =
            |row: &&Row| row.predicted.is_some_and(|p| row.measured > NEAR * p || row.measured * NEAR < p);
        let missed: Vec<&Row> = self.rows.iter().filter(misses).collect();
        if !missed.is_empty() {
            console::say(format!(
                "\n{} of {} rows miss their prediction by more than {NEAR}:",
                missed.len(),
                self.rows.len()
            ))?;
            missed.iter().try_for_each(|row| console::say(line(row)))?;
        }
        let wrong = self.rows.iter().filter(|row| row.equal == Some(false)).count();
        if wrong > 0 {
            bail!("{wrong} rows differ from one thread a ray; see \"equal\" in {}", self.path.display());
        }
        Ok(())
    }
}

fn line(row: &Row) -> String {
    let predicted = row.predicted.map_or(String::new(), |predicted| format!(" ({predicted:.3} predicted)"));
    let equal = if row.equal == Some(false) { ", NOT EQUAL" } else { "" };
    format!("{}: {:.3} {}{predicted}{equal}", row.what, row.measured, row.unit)
}
