//! Time from the end of one frame in motion to the start of the next.

use std::time::Instant;

/// Weight of the last pause in the moving average.
const NEW: f64 = 0.35;
/// Part of the interval of pictures that pauses may take from frames at most.
const MOST: f64 = 0.5;

/// Measures the pauses between frames: a picture is handed over and drawn, and the window asks for the next one.
#[derive(Debug, Default)]
pub struct Turnaround {
    ended: Option<Instant>,
    mean_ms: f64,
}

impl Turnaround {
    /// A frame begins. Returns the milliseconds that are left for it, of `interval_ms` from picture to picture.
    pub fn begin(&mut self, interval_ms: f64) -> f64 {
        let pause = self.ended.take().map(|ended| ended.elapsed().as_secs_f64() * 1e3);
        self.left(pause, interval_ms)
    }

    /// A frame ends.
    pub fn end(&mut self) {
        self.ended = Some(Instant::now());
    }

    /// A pause longer than the interval is the user's, who asks for no pictures.
    fn left(&mut self, pause_ms: Option<f64>, interval_ms: f64) -> f64 {
        if let Some(pause) = pause_ms.filter(|pause| *pause < interval_ms) {
            self.mean_ms += NEW * (pause - self.mean_ms);
        }
        interval_ms - self.mean_ms.min(MOST * interval_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_are_taken_from_frames_and_rests_are_not() {
        let mut turnaround = Turnaround::default();
        assert_eq!(turnaround.left(None, 80.0), 80.0);
        assert_eq!(turnaround.left(Some(5000.0), 80.0), 80.0);
        let left = (0..20).map(|_| turnaround.left(Some(20.0), 80.0)).last().unwrap();
        assert!((left - 60.0).abs() < 0.1, "{left}");
        assert_eq!(turnaround.left(None, 10.0), 5.0);
    }

    #[test]
    fn pauses_are_measured_from_end_to_begin() {
        let mut turnaround = Turnaround::default();
        turnaround.end();
        std::thread::sleep(std::time::Duration::from_millis(2));
        assert!(turnaround.begin(1e6) < 1e6);
        let left = turnaround.begin(1e6);
        assert_eq!(turnaround.begin(1e6), left, "no frame has ended");
    }
}
