//! Conversions between display colours, CIE XYZ and CIE L*a*b*.

/// Display RGB, 0…1 each.
pub type Colour = [f64; 3];

/// White D65.
const WHITE: Colour = [0.950_47, 1.0, 1.088_83];

/// The CIE XYZ of a display colour.
pub fn to_xyz(rgb: Colour) -> Colour {
    let [r, g, b] = rgb.map(|c| if c > 0.040_45 { ((c + 0.055) / 1.055).powf(2.4) } else { c / 12.92 });
    [
        0.412_4 * r + 0.357_6 * g + 0.180_5 * b,
        0.212_6 * r + 0.715_2 * g + 0.072_2 * b,
        0.019_3 * r + 0.119_2 * g + 0.950_5 * b,
    ]
}

/// The display colour of CIE XYZ.
pub fn from_xyz([x, y, z]: Colour) -> Colour {
    let linear = [
        3.240_6 * x - 1.537_2 * y - 0.498_6 * z,
        -0.968_9 * x + 1.875_8 * y + 0.041_5 * z,
        0.055_7 * x - 0.204 * y + 1.057 * z,
    ];
    let rgb = linear.map(|c| if c > 0.003_130_8 { 1.055 * c.powf(1.0 / 2.4) - 0.055 } else { 12.92 * c });
    // Colours that are too bright for display keep their hue, as in VTK.
    let most = rgb.into_iter().fold(1.0, f64::max);
    rgb.map(|c| (c / most).max(0.0))
}

/// The CIE L*a*b* of a display colour, white D65.
pub fn to_lab(rgb: Colour) -> Colour {
    let xyz = to_xyz(rgb);
    let f: Colour = std::array::from_fn(|i| {
        let t = xyz[i] / WHITE[i];
        if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 }
    });
    [116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])]
}

/// The display colour of CIE L*a*b*, white D65.
pub fn from_lab([l, a, b]: Colour) -> Colour {
    let fy = (l + 16.0) / 116.0;
    let f = [fy + a / 500.0, fy, fy - b / 200.0];
    from_xyz(std::array::from_fn(|i| {
        let cube = f[i].powi(3);
        WHITE[i] * if cube > 0.008_856 { cube } else { (f[i] - 16.0 / 116.0) / 7.787 }
    }))
}
