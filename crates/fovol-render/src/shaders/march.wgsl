// Marches rays: a thread follows a ray, and its shadow rays. Twin of cpu/march.rs.

/// Marches the ray through the centre of `pixel`.
fn march(pixel: vec2u) -> RayResult {
    let segment = segment_of(pixel);
    var few = few_shadow_rays(pixel);
    if FEW > 0u {
        // Places for shadow rays are chosen by the luminance of the whole ray.
        _ = march_with(segment, &few);
        few.whole = few.before;
        few.before = 0.0;
    }
    return march_with(segment, &few);
}

/// Marches the ray of `segment`, whose shadow rays are `few` or all.
fn march_with(segment: Segment, few: ptr<function, FewShadowRays>) -> RayResult {
    if MODE != COMPOSITE {
        return mode_march(segment);
    }
    if FINE {
        return fine_march(segment, few);
    }
    let inverse = inverse_of(segment.delta);
    var sums = no_sums();
    var k = 0.0;
    // Samples before this one may be visible.
    var known = 0.0;
    while k < segment.count && sums.opacity < OPAQUE {
        let p = fma(vec3f(k), segment.delta, segment.start);
        if SKIP && k >= known {
            let ahead = look_ahead(p, inverse);
            known = k + ahead.steps;
            if ahead.empty {
                k = known;
                continue;
            }
        }
        let looks = look_at(p);
        let alpha = bitcast<f32>(looks.x);
        if alpha > 0.0 {
            let weight = cover(&sums, k, alpha);
            if FEW > 0u {
                let full = light_of(p, 1.0);
                shine(&sums, weight, looks.y, full);
                let direct = weight * (full.x - scene.ambient) * colour_of(looks.y);
                let factor = chosen(few, direct);
                if factor > 0.0 {
                    sums.colour += factor * (transmittance(p) - 1.0) * direct;
                }
            } else {
                shine(&sums, weight, looks.y, light(p));
            }
        }
        k += 1.0;
    }
    return result_of(sums, segment);
}

/// Marches the pixels of the list.
@compute @workgroup_size(LIST_GROUP)
fn march_list(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let i = list_position(group, thread);
    if i < list_length.pixels {
        let pixel = unpacked(list[i]);
        put_listed(i, pixel, march(pixel));
    }
}

/// Marches every pixel, or those of the mask. Results are at the places of their pixels.
@compute @workgroup_size(8, 8)
fn march_frame(@builtin(global_invocation_id) place: vec3u) {
    let pixel = place.xy;
    if pixel.x >= extent.width || pixel.y >= extent.height {
        return;
    }
    if REJECT && !is_masked(pixel) {
        return;
    }
    put_in_frame(pixel, march(pixel));
}
