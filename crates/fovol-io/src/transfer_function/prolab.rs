//! The projective colour space ProLab.
//!
//! Source: Konovalenko, Smagina, Nikolaev and Nikolaev, "ProLab: Perceptually Uniform Projective Color Coordinate
//! System", IEEE Access 9, 2021.

use super::cie::{Colour, from_xyz, to_xyz};
use glam::{DMat4, DVec3, DVec4};

/// White point D65, rounded like VTK's.
const WHITE: DVec3 = DVec3::new(0.9505, 1.0, 1.089);

/// The matrix of the paper, rounded as VTK rounds it, by columns.
const FROM_XYZ: DMat4 = DMat4::from_cols(
    DVec4::new(75.54, 617.72, 48.34, 0.7554),
    DVec4::new(486.66, -595.45, 194.94, 3.8666),
    DVec4::new(167.39, -22.27, -243.28, 1.6739),
    DVec4::W,
);

/// The ProLab coordinates of a display colour.
pub fn to_prolab(rgb: Colour) -> Colour {
    FROM_XYZ.project_point3(DVec3::from_array(to_xyz(rgb)) / WHITE).to_array()
}

/// The display colour of ProLab coordinates.
pub fn from_prolab(prolab: Colour) -> Colour {
    from_xyz((FROM_XYZ.inverse().project_point3(DVec3::from_array(prolab)) * WHITE).to_array())
}
