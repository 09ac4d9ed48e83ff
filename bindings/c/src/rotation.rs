use glam::{DMat3, DQuat, DVec3};

/// Rotation that turns the direction `up` to +y; `None` if it has no length.
pub fn upright(up: DVec3) -> Option<DMat3> {
    let up = up.try_normalize()?;
    // Exact for the usual direction, so that such cameras are those of the command line.
    if up == DVec3::Y {
        return Some(DMat3::IDENTITY);
    }
    Some(DMat3::from_quat(DQuat::from_rotation_arc(up, DVec3::Y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_becomes_y() {
        for up in [DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::new(1.0, -2.0, 0.5)] {
            let turn = upright(up).unwrap();
            assert!((turn * up.normalize() - DVec3::Y).length() < 1e-12, "{up}");
            assert!((turn.determinant() - 1.0).abs() < 1e-12);
        }
        assert_eq!(upright(2.0 * DVec3::Y), Some(DMat3::IDENTITY));
        assert!(upright(DVec3::ZERO).is_none() && upright(DVec3::NAN).is_none());
    }
}
