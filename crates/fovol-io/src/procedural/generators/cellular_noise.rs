use super::seeded::lattice;
use glam::Vec3;

/// Cellular noise after Worley, "A cellular texture basis function" (1996): one point in each cell
/// of a lattice, distances to the nearest.
#[derive(Clone, Copy)]
pub(super) struct CellularNoise {
    seed: u32,
}

impl CellularNoise {
    pub fn new(seed: u64) -> Self {
        Self { seed: (seed ^ (seed >> 32)) as u32 }
    }

    /// Distances to the nearest and to the second nearest point; cells of size 1.
    pub fn nearest_two(self, p: Vec3) -> [f32; 2] {
        let cell = p.floor().as_ivec3();
        let mut nearest = [f32::INFINITY; 2];
        for z in -1..=1 {
            for y in -1..=1 {
                for x in -1..=1 {
                    let at = [cell.x + x, cell.y + y, cell.z + z];
                    let distance = self.point(at).distance_squared(p);
                    if distance < nearest[0] {
                        nearest = [distance, nearest[0]];
                    } else if distance < nearest[1] {
                        nearest[1] = distance;
                    }
                }
            }
        }
        nearest.map(f32::sqrt)
    }

    /// 0 on the walls between cells, rising to about 1 inside.
    pub fn inside(self, p: Vec3) -> f32 {
        let [first, second] = self.nearest_two(p);
        second - first
    }

    fn point(self, cell: [i32; 3]) -> Vec3 {
        let hash = lattice(self.seed, cell);
        let offset = Vec3::new((hash & 1023) as f32, (hash >> 10 & 1023) as f32, (hash >> 20 & 1023) as f32);
        Vec3::from_array(cell.map(|c| c as f32)) + offset / 1024.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_comes_first_and_is_near() {
        let noise = CellularNoise::new(3);
        for i in 0..2000 {
            let p = Vec3::new(i as f32 * 0.37, i as f32 * -0.11, 0.5);
            let [first, second] = noise.nearest_two(p);
            assert!(first <= second && first < 1.5, "{first} {second}");
        }
    }
}
