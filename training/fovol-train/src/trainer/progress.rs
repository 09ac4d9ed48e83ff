use super::taken::Taken;
use super::validation::Judgement;
use crate::terminal::say;
use crate::{Error, Result};
use plotters::prelude::*;
use serde_json::json;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Progress reports of a run: a line in `log.jsonl` for every step and validation, a chart of the loss, and
/// occasional lines on the terminal.
pub(super) struct Progress {
    log: File,
    path: PathBuf,
    started: Instant,
    first: u64,
    steps: u64,
    /// End of a run that follows the clock.
    end: Option<Instant>,
    said: Instant,
    /// Exponential moving average of the loss.
    mean: Option<f64>,
}

/// Seconds between lines on the terminal.
const PAUSE: f64 = 20.0;

impl Progress {
    /// Continues the log in `folder` from step `first` of `steps`, or until `end`. Lines of later steps are dropped,
    /// since these steps are repeated.
    pub fn new(folder: &Path, first: u64, steps: u64, end: Option<Instant>) -> Result<Self> {
        let path = folder.join("log.jsonl");
        let kept: Vec<String> =
            lines(&path).into_iter().filter(|line| step_of(line).is_some_and(|s| s < first)).collect();
        let text: String = kept.iter().map(|line| format!("{line}\n")).collect();
        std::fs::write(&path, text).map_err(|e| Error::file("write", &path, &e))?;
        let log = OpenOptions::new().append(true).open(&path).map_err(|e| Error::file("write", &path, &e))?;
        let now = Instant::now();
        Ok(Self { log, path, started: now, first, steps, end, said: now, mean: None })
    }

    /// Reports that step `step` was taken.
    pub fn step(&mut self, step: u64, rate: f64, taken: &Taken) -> Result<()> {
        let terms: serde_json::Map<String, serde_json::Value> =
            taken.terms.iter().map(|&(name, value)| (name.into(), json!(value))).collect();
        self.write(&json!({ "step": step, "rate": rate, "norm": taken.norm, "loss": terms }))?;
        let loss = taken.terms[0].1;
        self.mean = Some(self.mean.map_or(loss, |mean| 0.99 * mean + 0.01 * loss));
        if self.said.elapsed().as_secs_f64() > PAUSE {
            self.said = Instant::now();
            self.say(step + 1);
        }
        Ok(())
    }

    /// Reports that step `step` was skipped because its gradients were not finite.
    pub fn skipped(&mut self, step: u64) -> Result<()> {
        self.write(&json!({ "step": step, "skipped": true }))
    }

    /// Reports that `channels` dead channels were reset before step `step`.
    pub fn revived(&mut self, step: u64, channels: usize) -> Result<()> {
        self.write(&json!({ "step": step, "revived": channels }))?;
        say(format_args!("step {step}: {channels} channels that had died begin anew"));
        Ok(())
    }

    /// Reports the validation before step `step`.
    pub fn judged(&mut self, step: u64, judgement: &Judgement) -> Result<()> {
        self.write(&json!({ "step": step - 1, "judged": judgement }))?;
        say(format_args!("step {step}: {judgement}"));
        self.draw()
    }

    fn say(&self, step: u64) {
        let seconds = self.started.elapsed().as_secs_f64();
        let each = seconds / (step - self.first).max(1) as f64;
        let (of, left) = match self.end {
            Some(end) => (String::new(), end.saturating_duration_since(Instant::now()).as_secs_f64()),
            None => (format!(" of {}", self.steps), each * (self.steps - step) as f64),
        };
        let mean = self.mean.unwrap_or(f64::NAN);
        say(format_args!("step {step}{of}: loss {mean:.5}, {each:.2} s a step, {:.0} min left", left / 60.0));
    }

    fn write(&mut self, line: &serde_json::Value) -> Result<()> {
        writeln!(self.log, "{line}").map_err(|e| Error::file("write", &self.path, &e))
    }

    /// Draws `loss.svg`: the loss averaged over a hundred parts of the run.
    fn draw(&self) -> Result<()> {
        let all: Vec<(f64, f64)> = lines(&self.path)
            .iter()
            .filter_map(|line| {
                let value: serde_json::Value = serde_json::from_str(line).ok()?;
                Some((value["step"].as_f64()?, value["loss"]["total"].as_f64()?))
            })
            .collect();
        if all.is_empty() {
            return Ok(());
        }
        let mean = |part: &[(f64, f64)]| {
            let sum = part.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            (sum.0 / part.len() as f64, sum.1 / part.len() as f64)
        };
        let points: Vec<(f64, f64)> = all.chunks(all.len().div_ceil(100)).map(mean).collect();
        let path = self.path.with_file_name("loss.svg");
        draw_curve(&path, &points).map_err(|e| Error::Config(format!("cannot draw {}: {e}", path.display())))
    }
}

fn draw_curve(path: &Path, points: &[(f64, f64)]) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let (least, most) =
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.1), b.max(p.1)));
    let area = SVGBackend::new(path, (640, 360)).into_drawing_area();
    area.fill(&WHITE)?;
    let steps = 0.0..points[points.len() - 1].0.max(1.0);
    let mut chart = ChartBuilder::on(&area);
    chart.margin(12).x_label_area_size(34).y_label_area_size(58);
    let curve = LineSeries::new(points.iter().copied(), &BLUE);
    // Sums of logarithms are negative, and need no logarithmic axis.
    if least > 0.0 {
        let mut chart = chart.build_cartesian_2d(steps, (0.9 * least..1.1 * most).log_scale())?;
        chart.configure_mesh().x_desc("step").y_desc("loss").draw()?;
        chart.draw_series(curve)?;
    } else {
        let margin = 0.05 * (most - least).max(1e-9);
        let mut chart = chart.build_cartesian_2d(steps, least - margin..most + margin)?;
        chart.configure_mesh().x_desc("step").y_desc("loss").draw()?;
        chart.draw_series(curve)?;
    }
    area.present()?;
    Ok(())
}

fn lines(path: &Path) -> Vec<String> {
    File::open(path).map_or_else(
        |_| Vec::new(),
        |file| BufReader::new(file).lines().map_while(std::result::Result::ok).collect(),
    )
}

fn step_of(line: &str) -> Option<u64> {
    serde_json::from_str::<serde_json::Value>(line).ok()?["step"].as_u64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_any_sign_are_drawn() {
        let folder = tempfile::tempdir().unwrap();
        for (name, values) in [("above", [0.5, 0.2, 0.1]), ("below", [-1.0, -3.0, -7.0]), ("flat", [0.0; 3])]
        {
            let path = folder.path().join(name);
            let points: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, &v)| (i as f64, v)).collect();
            draw_curve(&path, &points).unwrap();
            assert!(std::fs::read_to_string(&path).unwrap().contains("polyline"), "{name}");
        }
    }
}
