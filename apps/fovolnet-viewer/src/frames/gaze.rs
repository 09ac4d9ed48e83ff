//! Sources of the gaze.

use fovolnet::core::GazePath;

/// Source of the gaze: the pointer, a script, or an eye tracker.
pub trait GazeSource {
    /// Gaze in frame `frame`, as fractions of the picture from its top left. `pointer` is the pointer's position over
    /// the picture, or `None`.
    fn gaze(&mut self, frame: u32, pointer: Option<[f64; 2]>) -> [f64; 2];
}

/// Gaze that follows the pointer, and stays where the pointer left the picture.
#[derive(Debug)]
pub struct PointerGaze {
    last: [f64; 2],
}

impl Default for PointerGaze {
    fn default() -> Self {
        Self { last: [0.5; 2] }
    }
}

impl GazeSource for PointerGaze {
    fn gaze(&mut self, _frame: u32, pointer: Option<[f64; 2]>) -> [f64; 2] {
        self.last = pointer.unwrap_or(self.last);
        self.last
    }
}

impl GazeSource for GazePath {
    fn gaze(&mut self, frame: u32, _pointer: Option<[f64; 2]>) -> [f64; 2] {
        Self::gaze(self, frame)
    }
}

/// Gaze sources that the viewer offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GazeKind {
    /// The pointer.
    #[default]
    Pointer,
    /// The session's setting: a point, `wander`, or a script.
    Session,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_stays_where_the_pointer_left() {
        let mut source = PointerGaze::default();
        assert_eq!(source.gaze(0, None), [0.5, 0.5]);
        assert_eq!(source.gaze(1, Some([0.2, 0.9])), [0.2, 0.9]);
        assert_eq!(source.gaze(2, None), [0.2, 0.9]);
    }

    #[test]
    fn scripts_pay_no_attention_to_the_pointer() {
        let mut script = GazePath::scripted(vec![[0.0, 0.0, 0.0], [10.0, 1.0, 0.5]]).unwrap();
        assert_eq!(GazeSource::gaze(&mut script, 5, Some([0.9, 0.9])), [0.5, 0.25]);
    }
}
