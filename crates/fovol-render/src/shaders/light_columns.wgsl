// Which samples of a shadow ray may meet anything, known before the ray is followed. Twin of cpu/light_columns.rs.

/// Whether there are columns for the light of the scene.
override COLUMNS: bool = false;

/// Slabs of one word.
const SLABS: u32 = 32;

/// Words of columns: a bit says whether a slab touches anything visible, the lowest is for the first of 32 slabs. Words of a
/// column lie along z.
@group(0) @binding(8) var column_words: texture_3d<u32>;

/// The column of a shadow ray, and the slab of its first sample.
struct InColumn {
    column: vec2i,
    first: u32,
}

/// The column of the shadow ray from `p`.
fn in_column(p: vec3f) -> InColumn {
    // The other axes follow in turn.
    let columns = scene.columns;
    let first = columns.axes.x;
    let turned = select(select(p.zxy, p.yzx, first == 1u), p, first == 0u);
    // A point a rounding error outside the box is taken for one on its face.
    let depth = max((turned.x - columns.origin) * columns.slabs, 0.0);
    let across = turned.yz - fma(vec2f(depth), columns.shear, columns.low);
    let column = clamp(across * columns.density, vec2f(0.0), columns.last);
    return InColumn(vec2i(column), u32(depth + 0.5));
}

/// Slabs from `first` on and before `end` that may show something, among those of word `word` of `column`.
fn listed(column: vec2i, word: u32, first: u32, end: u32) -> u32 {
    var bits = textureLoad(column_words, vec3i(column, i32(word)), 0).x;
    let start = word * SLABS;
    if first > start {
        bits &= 0xFFFFFFFFu << (first - start);
    }
    if end < start + SLABS {
        bits &= 0xFFFFFFFFu >> (start + SLABS - end);
    }
    return bits;
}
