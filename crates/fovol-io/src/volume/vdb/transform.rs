//! The way from the indices of voxels to the world.

use super::cursor::Cursor;
use crate::volume::active_box::scaled;
use crate::volume::affine::Affine;
use glam::DVec3;

/// Reads the transform at `cursor`. It names a kind that is not affine as `Err`.
pub fn parse(cursor: &mut Cursor<'_>) -> Option<Result<Affine, String>> {
    let kind = cursor.text()?;
    Some(Ok(match kind.as_str() {
        // Behind the scale stand numbers that follow from it.
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector(cursor)?;
            cursor.take(4 * 24)?;
            scaled(scale, DVec3::ZERO)
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (translation, scale) = (vector(cursor)?, vector(cursor)?);
            cursor.take(4 * 24)?;
            scaled(scale, translation)
        }
        "TranslationMap" => scaled(DVec3::ONE, vector(cursor)?),
        // A vector stands before the matrix that it is multiplied by, so that rows are steps.
        "AffineMap" | "UnitaryMap" => {
            let mut rows = [DVec3::ZERO; 4];
            for row in &mut rows {
                *row = vector(cursor)?;
                cursor.take(8)?;
            }
            let [x, y, z, origin] = rows;
            Affine { steps: [x, y, z], origin }
        }
        _ => return Some(Err(kind)),
    }))
}

fn vector(cursor: &mut Cursor<'_>) -> Option<DVec3> {
    cursor.vector().map(DVec3::from_array)
}
