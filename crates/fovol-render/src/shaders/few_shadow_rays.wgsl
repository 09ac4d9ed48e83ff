// Shadow rays for a few places of each ray, which stand for all of them. Twin of cpu/few_shadow_rays.rs.

/// Shadow rays of each pixel; 0 where every sample has one.
override FEW: u32 = 0;

/// Least number of shadow rays that stand for trapezoids.
const TRAPEZOIDS: u32 = 4;
/// Pixels between the noise of masks and that of shadow rays.
const SHIFT: vec2u = vec2u(59, 31);
/// Edge in pixels of the tile of noise that repeats over the frame.
const NOISE_TILE: u32 = 128;
/// Shares of red, green and blue in luminance.
const LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);

/// Ranks of the noise of one frame, unless they are hashed.
@group(1) @binding(7) var noise_tile: texture_3d<u32>;

/// Light of a ray, and where its next shadow ray begins.
struct FewShadowRays {
    /// Luminance of the whole ray in full light; 0 until it is known.
    whole: f32,
    /// Luminance of the places so far.
    before: f32,
    /// Noise of the ray, 0…1.
    offset: f32,
    /// Number of the next shadow ray.
    next: u32,
}

/// Shadow rays of `pixel`, whose ray was not marched yet.
fn few_shadow_rays(pixel: vec2u) -> FewShadowRays {
    if FEW == 0u {
        return FewShadowRays(0.0, 0.0, 0.0, 0u);
    }
    let at = pixel + SHIFT;
    // The upper 20 of 64 bits.
    let hashed = hash(view.noise_seed, at).y >> 12u;
    let listed = textureLoad(noise_tile, vec3u(at % NOISE_TILE, 0u), 0).x;
    // No branch, since some drivers compile a shader for every command if a uniform decides one.
    let rank = select(listed, hashed, view.noise_hashed != 0u);
    return FewShadowRays(0.0, 0.0, (f32(rank) + 0.5) / view.noise_levels, 0u);
}

/// Share of the light that the next shadow ray stands for.
fn share_of_next(few: FewShadowRays) -> f32 {
    var rays = 1.0;
    if FEW >= TRAPEZOIDS && few.next == 0u {
        rays = few.offset + 0.5;
    } else if FEW >= TRAPEZOIDS && few.next + 1u == FEW {
        rays = 1.5 - few.offset;
    }
    return rays / f32(FEW);
}

/// Passes a place of this colour in full light. Returns the factor by which it stands for other places, too; 0 if no shadow ray
/// begins there, and for all places of a ray that is passed for the first time.
fn chosen(few: ptr<function, FewShadowRays>, colour: vec3f) -> f32 {
    let own = dot(colour, LUMINANCE);
    (*few).before += own;
    var share = 0.0;
    while (*few).whole > 0.0 && (*few).next < FEW
        && (f32((*few).next) + (*few).offset) / f32(FEW) * (*few).whole <= (*few).before {
        share += share_of_next(*few);
        (*few).next += 1u;
    }
    if share == 0.0 || own <= 0.0 {
        return 0.0;
    }
    return share * (*few).whole / own;
}
