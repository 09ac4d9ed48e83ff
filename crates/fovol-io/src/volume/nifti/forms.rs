//! Orientation and position of NIfTI volumes: the qform and the sform.
//!
//! Source: <https://nifti.nimh.nih.gov/nifti-1/documentation/nifti1fields/nifti1fields_pages/qsform.html>.

use crate::volume::affine::Affine;
use glam::{DMat3, DVec3};

/// The numbers of a header that place its voxels, and their codes. Coordinates are RAS.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Forms {
    /// The rows of the sform, where its code is above 0.
    pub sform: Option<[[f64; 4]; 3]>,
    /// The qform, where its code is above 0.
    pub qform: Option<Quaternion>,
}

/// The rotation and the shift of a qform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quaternion {
    /// b, c and d; a follows from them.
    pub imaginary: [f64; 3],
    /// The centre of the first voxel.
    pub offset: [f64; 3],
    /// Whether the third axis is turned round: `pixdim[0]` is below 0.
    pub is_flipped: bool,
}

/// Where a header places its voxels, how far apart they are, and the doubts about that.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The placement, if the header has one.
    pub affine: Option<Affine>,
    /// The distance between voxels.
    pub spacing: [f64; 3],
    /// Doubts, a line each.
    pub notes: Vec<String>,
}

/// Spacings contradict each other where they differ by more than this part: rounding to few digits explains less.
const SAME: f64 = 1e-3;

/// Squares of a below this are 0.
const HALF_A_TURN: f64 = 1e-7;

/// Relative tolerance for rounding to single precision.
const EQUAL: f64 = 1e-5;

impl Forms {
    /// The place by the rules of the standard: the sform where it has a code, else the qform where it has one, else
    /// none. `pixdim` is the spacing that the header states besides.
    pub fn placed(&self, pixdim: [f64; 3]) -> Placed {
        let mut placed = Placed { affine: None, spacing: pixdim, notes: Vec::new() };
        let sform = self.sform.map(|rows| affine_of(&rows).spanning());
        let qform = self.qform.map(|quaternion| quaternion.affine(pixdim));
        match (sform, qform) {
            (Some(sform), qform) if is_sound(&sform) => placed.take_sform(sform, qform, pixdim),
            (broken, Some(qform)) if is_sound(&qform) => {
                if broken.is_some() {
                    placed.notes.push("its sform spans no space; its qform is used".into());
                }
                placed.affine = Some(qform);
            }
            (None, None) => {}
            _ => placed.notes.push(
                "its sform and qform span no space; only its pixdim is used, and left and right may be swapped"
                    .into(),
            ),
        }
        placed
    }
}

impl Placed {
    fn take_sform(&mut self, sform: Affine, qform: Option<Affine>, pixdim: [f64; 3]) {
        let lengths = sform.spacing();
        let differs_by =
            |part: f64| (0..3).any(|axis| (lengths[axis] - pixdim[axis]).abs() > part * lengths[axis]);
        if differs_by(EQUAL) {
            self.spacing = lengths;
        }
        if differs_by(SAME) {
            let [found, other] = [lengths, pixdim].map(shown);
            self.notes.push(format!(
                "its sform has a spacing of {found}, its pixdim {other}; the sform is used, --spacing {} chooses the other",
                other.replace(' ', "")
            ));
        }
        let is_left_handed = |affine: &Affine| matrix(affine).determinant() < 0.0;
        if qform.is_some_and(|qform| is_sound(&qform) && is_left_handed(&qform) != is_left_handed(&sform)) {
            self.notes.push("its sform and qform are mirror images of each other; the sform is used".into());
        }
        self.affine = Some(sform);
    }
}

/// `spacing` for people, with the digits of a single.
fn shown(spacing: [f64; 3]) -> String {
    spacing.map(|length| (length as f32).to_string()).join(", ")
}

fn affine_of(rows: &[[f64; 4]; 3]) -> Affine {
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    Affine::from_ras([column(0), column(1), column(2)], column(3))
}

fn matrix(affine: &Affine) -> DMat3 {
    let [x, y, z] = affine.steps;
    DMat3::from_cols(x, y, z)
}

/// Whether the axes span space.
fn is_sound(affine: &Affine) -> bool {
    let lengths: f64 = affine.spacing().iter().product();
    let volume = matrix(affine).determinant().abs();
    volume.is_finite() && affine.origin.is_finite() && lengths > 0.0 && volume > 1e-3 * lengths
}

impl Quaternion {
    /// The affine map, by the formula of the standard.
    fn affine(self, pixdim: [f64; 3]) -> Affine {
        let [b, c, d] = self.imaginary;
        let square = b * b + c * c + d * d;
        // Half a turn, rounded: the reference code of the standard scales it so too.
        let (a, b, c, d) = match 1.0 - square < HALF_A_TURN {
            true => (0.0, b / square.sqrt(), c / square.sqrt(), d / square.sqrt()),
            false => ((1.0 - square).sqrt(), b, c, d),
        };
        let third = if self.is_flipped { -1.0 } else { 1.0 };
        let [x, y, z] = [
            DVec3::new(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
            DVec3::new(2.0 * (b * c - a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d + a * b)),
            DVec3::new(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a + d * d - b * b - c * c) * third,
        ];
        let steps = [x * pixdim[0], y * pixdim[1], z * pixdim[2]];
        Affine::from_ras(steps, DVec3::from_array(self.offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> [[f64; 4]; 3] {
        [0, 1, 2].map(|row| [x[row], y[row], z[row], 10.0])
    }

    #[test]
    fn the_sform_wins_and_contradictions_are_noted() {
        let sform = rows([-2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]);
        let forms = Forms { sform: Some(sform), qform: None };
        let placed = forms.placed([1.0; 3]);
        assert_eq!(placed.spacing, [2.0, 2.0, 4.0]);
        assert!(
            placed.notes[0].contains("2, 2, 4") && placed.notes[0].contains("1, 1, 1"),
            "{:?}",
            placed.notes
        );
        let affine = placed.affine.unwrap();
        assert_eq!(affine.steps[0], DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(affine.origin, DVec3::new(-10.0, -10.0, 10.0));
        assert!(forms.placed([2.0, 2.0, 4.0]).notes.is_empty());
        let rounded = forms.placed([2.001, 2.0, 4.0]);
        assert_eq!((rounded.spacing, rounded.notes.len()), ([2.0, 2.0, 4.0], 0));
    }

    #[test]
    fn quaternions_turn_as_the_standard_says() {
        // Half a turn about z: RAS to LPS.
        let quaternion = Quaternion { imaginary: [0.0, 0.0, 1.0], offset: [0.0; 3], is_flipped: true };
        let affine = Forms { sform: None, qform: Some(quaternion) }.placed([1.0, 2.0, 3.0]).affine.unwrap();
        assert_eq!(affine.steps, [DVec3::X, DVec3::Y * 2.0, DVec3::NEG_Z * 3.0]);
        let rounded = Quaternion { imaginary: [0.0, 0.0, 1.0 - 3e-8], ..quaternion };
        let affine = Forms { sform: None, qform: Some(rounded) }.placed([1.0, 2.0, 3.0]).affine.unwrap();
        assert_eq!(affine.steps, [DVec3::X, DVec3::Y * 2.0, DVec3::NEG_Z * 3.0]);
    }

    #[test]
    fn forms_that_span_no_space_are_not_used() {
        let flat = rows([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let quaternion = Quaternion { imaginary: [0.0; 3], offset: [0.0; 3], is_flipped: false };
        let placed = Forms { sform: Some(flat), qform: Some(quaternion) }.placed([1.0; 3]);
        assert!(placed.affine.is_some() && placed.notes[0].contains("qform is used"), "{placed:?}");
        let placed = Forms { sform: Some(flat), qform: None }.placed([1.0; 3]);
        assert!(placed.affine.is_none() && placed.notes.len() == 1);
        assert_eq!(Forms::default().placed([1.0; 3]).affine, None);
    }

    #[test]
    fn mirrored_forms_are_noted() {
        let sform = rows([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let quaternion = Quaternion { imaginary: [0.0; 3], offset: [0.0; 3], is_flipped: true };
        let placed = Forms { sform: Some(sform), qform: Some(quaternion) }.placed([1.0; 3]);
        assert!(placed.notes[0].contains("mirror"), "{placed:?}");
    }
}
