//! Steps of a ray.

/// A step of a ray: a look into the macrocells, a sample, or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Step {
    pub looks: bool,
    pub samples: bool,
}

impl Step {
    /// Everything that either of two lanes does.
    pub fn or(self, other: Self) -> Self {
        Self { looks: self.looks || other.looks, samples: self.samples || other.samples }
    }

    /// Texture loads: one for a look, two for a sample.
    pub fn loads(self) -> u64 {
        u64::from(self.looks) + 2 * u64::from(self.samples)
    }
}

/// Steps of one shadow ray.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ShadowSteps {
    pub steps: Vec<Step>,
    /// Words of its column that list them.
    pub words: u64,
}

impl ShadowSteps {
    /// Number of steps.
    pub fn count(&self) -> u64 {
        self.steps.len() as u64
    }
}

/// A sample that shows something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LitSample {
    /// Its number on the ray.
    pub number: u32,
    pub shadow: ShadowSteps,
}

/// Steps of one primary ray. Shadow rays belong to the steps that show something.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RaySteps {
    /// One after the other, as a thread that skips empty space takes them; with the place in `lit` where one shows
    /// something.
    pub steps: Vec<(Step, Option<usize>)>,
    pub lit: Vec<LitSample>,
    /// Number after the last sample that is taken.
    pub end: u32,
}

impl RaySteps {
    /// Steps of the ray and of its shadow rays, one after the other.
    pub fn chain(&self) -> u64 {
        self.steps.len() as u64 + self.lit.iter().map(|lit| lit.shadow.count()).sum::<u64>()
    }

    /// The shadow ray of step `i`, if it has one.
    pub fn shadow(&self, i: usize) -> Option<&ShadowSteps> {
        let (_, lit) = self.steps.get(i)?;
        lit.map(|lit| &self.lit[lit].shadow)
    }
}
