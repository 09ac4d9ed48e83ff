// Fine integration by a thread that follows a ray, and its shadow rays. Twin of cpu/fine/march.rs.

/// Marches the ray of `segment`, whose shadow rays are `few` or all.
fn fine_march(segment: Segment, few: ptr<function, FewShadowRays>) -> RayResult {
    let inverse = inverse_of(segment.delta);
    var sums = no_sums();
    var number = 0.0;
    // Steps before this one may be visible.
    var known = 0.0;
    var front = entry(field(boundary(segment, 0.0)));
    var is_lit = false;
    var before = Light(0.0, 1.0);
    while number < segment.length && sums.opacity < FINE_OPAQUE {
        if SKIP && number >= known {
            let ahead = look_ahead(boundary(segment, number), inverse);
            let jump = empty_steps(ahead);
            known = number + select(ahead.steps, 4.0, ahead.empty);
            if jump > 0.0 {
                number += jump;
                front = entry(field(boundary(segment, number)));
                is_lit = false;
                continue;
            }
        }
        let steps = steps_from(segment, number, 4, front);
        let count = steps_of_part(depth_of(steps, 0, 4));
        for (var first = 0; first < 4; first += count) {
            let depth = depth_of(steps, first, count);
            if depth == 0.0 {
                is_lit = false;
                continue;
            }
            let ends = vec2f(number + f32(first), number + f32(first + count));
            let opacity = sums.opacity;
            cover_part(&sums, number, steps, first, count);
            if FEW > 0u {
                let full = lit_part(segment, number, steps, first, count, opacity, 1.0);
                sums.colour += full.colour;
                sums.unshadowed += full.unshadowed;
                let factor = chosen(few, full.direct);
                if factor > 0.0 {
                    let lights = array<Light, 2>(light_at(boundary(segment, ends.x)), light_at(boundary(segment, ends.y)));
                    sums.colour += factor * (arriving_at(depth, lights[0], lights[1]) - 1.0) * full.direct;
                }
                continue;
            }
            if !is_lit {
                before = light_at(boundary(segment, ends.x));
            }
            let after = light_at(boundary(segment, ends.y));
            let arriving = arriving_at(depth, before, after);
            let lit = lit_part(segment, number, steps, first, count, opacity, arriving);
            sums.colour += lit.colour;
            sums.unshadowed += lit.unshadowed;
            before = after;
            is_lit = true;
        }
        front = steps.entries[4];
        number += 4.0;
    }
    return fine_result(sums, segment);
}
