use fovol_core::{Frame, SparseFrame};
use rayon::prelude::*;
use spade::{DelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

/// A sampled pixel as a vertex of the triangulation.
struct Sample {
    at: Point2<f64>,
    colour: [f32; 3],
}

impl HasPosition for Sample {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type Mesh = DelaunayTriangulation<Sample, (), (), (), HierarchyHintGenerator<f64>>;

/// Number of rows that one task fills.
const ROWS: usize = 16;

/// Interpolates linearly in the Delaunay triangulation of the samples. Outside it the nearest sample counts.
pub fn linear(sparse: &SparseFrame) -> Frame {
    let size = sparse.size();
    let mut frame = sparse.to_frame();
    let samples = samples_of(sparse);
    if samples.is_empty() {
        frame.fill([0.0, 0.0, 0.0, 1.0]);
        return frame;
    }
    let mesh = Mesh::bulk_load_stable(samples).expect("pixel positions are finite");
    draw_triangles(&mesh, &mut frame);
    let width = size.width as usize;
    frame.pixels_mut().par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        for (i, p) in rows.iter_mut().enumerate() {
            if p[3] <= 0.5 {
                let at = Point2::new((i % width) as f64, (chunk * ROWS + i / width) as f64);
                let [r, g, b] = mesh.nearest_neighbor(at).map_or([0.0; 3], |v| v.data().colour);
                *p = [r, g, b, 1.0];
            }
        }
    });
    frame
}

fn samples_of(sparse: &SparseFrame) -> Vec<Sample> {
    let samples = sparse.pixels().iter().zip(sparse.colours());
    samples.map(|(p, &colour)| Sample { at: Point2::new(p.x.into(), p.y.into()), colour }).collect()
}

/// Fills the unsampled pixels that the triangles cover.
fn draw_triangles(mesh: &Mesh, frame: &mut Frame) {
    let width = frame.size().width as usize;
    for face in mesh.inner_faces() {
        let corners = face.vertices().map(|v| (v.position(), v.data().colour));
        let [(a, colour_a), (b, colour_b), (c, colour_c)] = corners;
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let (top, bottom) = (a.y.min(b.y).min(c.y) as usize, a.y.max(b.y).max(c.y) as usize);
        let (left, right) = (a.x.min(b.x).min(c.x) as usize, a.x.max(b.x).max(c.x) as usize);
        for y in top..=bottom {
            for x in left..=right {
                let pixel = &mut frame.pixels_mut()[y * width + x];
                if pixel[3] > 0.5 {
                    continue;
                }
                // Barycentric coordinates: doubled areas of the parts towards b and c, over that of the triangle.
                let (px, py) = (x as f64 - a.x, y as f64 - a.y);
                let to_b = (px * (c.y - a.y) - py * (c.x - a.x)) / area;
                let to_c = (py * (b.x - a.x) - px * (b.y - a.y)) / area;
                if to_b >= 0.0 && to_c >= 0.0 && to_b + to_c <= 1.0 {
                    let (u, v) = (to_b as f32, to_c as f32);
                    for i in 0..3 {
                        pixel[i] = colour_a[i] * (1.0 - u - v) + colour_b[i] * u + colour_c[i] * v;
                    }
                    pixel[3] = 1.0;
                }
            }
        }
    }
}
