//! Other programs on the machine while figures are timed.

use std::time::Instant;

/// Share of the processors that other programs may use without a note.
const QUIET: f64 = 0.1;

/// Start of a stretch of time, with the processor times so far.
pub struct Watch {
    started: Instant,
    times: Option<Times>,
}

/// Processor times in clock ticks: of all programs, and of this one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Times {
    /// Used by programs, or withheld by the host of a virtual machine; summed over all processors.
    used: f64,
    /// All ticks, idle ones too.
    all: f64,
    own: f64,
}

impl Watch {
    /// Starts now.
    pub fn start() -> Self {
        Self { started: Instant::now(), times: Times::now() }
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Note on other programs that used more than a tenth of the processors since the start. `None` on systems that do not
    /// tell.
    pub fn note(&self) -> Option<String> {
        let share = self.times?.others(Times::now()?);
        (share > QUIET).then(|| {
            format!(
                "Other programs used {:.0} % of the processors meanwhile, so that times here are too high and vary.",
                100.0 * share
            )
        })
    }
}

impl Times {
    /// Times now, on Linux.
    fn now() -> Option<Self> {
        Self::parse(
            &std::fs::read_to_string("/proc/stat").ok()?,
            &std::fs::read_to_string("/proc/self/stat").ok()?,
        )
    }

    /// Times of the texts of `/proc/stat` and `/proc/self/stat`; see proc(5).
    fn parse(machine: &str, program: &str) -> Option<Self> {
        let line = machine.lines().next()?.strip_prefix("cpu ")?;
        let ticks: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let [user, nice, system, idle, iowait, irq, softirq, steal, ..] = ticks[..] else { return None };
        let used = user + nice + system + irq + softirq + steal;
        // The name of the program, in parentheses, may hold spaces. User and system time are fields 14 and 15.
        let fields: Vec<&str> = program.rsplit_once(')')?.1.split_whitespace().collect();
        let own = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
        Some(Self { used, all: used + idle + iowait, own })
    }

    /// Share of all processors that other programs used from these times to `later`.
    fn others(self, later: Self) -> f64 {
        let all = later.all - self.all;
        let others = later.used - self.used - (later.own - self.own);
        if all > 0.0 { (others / all).clamp(0.0, 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: [&str; 2] = [
        "cpu  100 0 50 800 50 0 0 0 0 0\ncpu0 50 0 25 400 25 0 0 0 0 0\n",
        "7 (a (b) c) R 1 7 7 0 -1 4194304 94 0 0 0 60 20 0 0 20 0 1 0 12345",
    ];
    const AFTER: [&str; 2] = [
        "cpu  200 20 80 1000 50 0 0 50 0 0\n",
        "7 (a (b) c) R 1 7 7 0 -1 4194304 94 0 0 0 140 40 0 0 20 0 1 0 12345",
    ];

    #[test]
    fn others_are_what_this_program_did_not_use() {
        let [before, after] =
            [BEFORE, AFTER].map(|[machine, program]| Times::parse(machine, program).unwrap());
        assert_eq!(before, Times { used: 150.0, all: 1000.0, own: 80.0 });
        // 200 of 400 ticks were used, 100 of them by this program.
        assert!((before.others(after) - 0.25).abs() < 1e-9);
        assert_eq!(before.others(before), 0.0);
        assert_eq!(Times::parse("cpu 1 2 3", BEFORE[1]), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_tells() {
        assert!(Times::now().is_some_and(|times| times.used > 0.0 && times.own >= 0.0));
    }
}
