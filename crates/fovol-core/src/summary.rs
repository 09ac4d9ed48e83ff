/// Statistics of a volume's finite values (first component, after scaling).
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Smallest finite value; 0 if there is none.
    pub min: f64,
    /// Largest finite value; 0 if there is none.
    pub max: f64,
    /// Mean of the finite values; 0 if there is none.
    pub mean: f64,
    /// Number of NaN or infinite values.
    pub non_finite: u64,
    /// Number of NaN values.
    pub nan: u64,
    /// Smallest and largest finite value without outliers.
    pub shown: [f64; 2],
    /// Values far outside all others, such as −9999 for voxels without data; smallest first.
    pub outliers: Vec<Outlier>,
}

/// Value far outside all others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// The value, after scaling.
    pub value: f64,
    /// Number of voxels with this value.
    pub count: u64,
}
