use super::fields::{choice, number, set};
use crate::ui::widgets::colour_button::colour_button;
use eframe::egui::{Color32, Mesh, Rect, Sense, Shape, Stroke, Ui, vec2};
use fovolnet::core::{Integration, ShadowMode, SurfaceShading};
use fovolnet::{RenderOverrides, RenderSettings, ShadowRays};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Panel for light, shadows and background.
pub fn scene(ui: &mut Ui, settings: &mut RenderOverrides) {
    let usual = RenderSettings::default();
    ui.horizontal(|ui| {
        light_ball(ui, settings);
        ui.vertical(|ui| {
            let mut shadows = settings.shadows.unwrap_or(usual.shadows);
            ui.horizontal(|ui| {
                ui.label("Shadows");
                for (mode, name) in
                    [(ShadowMode::On, "on"), (ShadowMode::Cached, "cached"), (ShadowMode::Off, "off")]
                {
                    ui.selectable_value(&mut shadows, mode, name);
                }
            });
            set(&mut settings.shadows, shadows, usual.shadows);
            let mut rays = settings.shadow_rays.unwrap_or(usual.shadow_rays);
            ui.add_enabled_ui(shadows == ShadowMode::On, |ui| {
                let offered =
                    ["exact", "32", "16", "8", "4", "1"].iter().filter_map(|text| text.parse().ok());
                let offered: Vec<ShadowRays> = offered.collect();
                choice(ui, "Shadow rays", &mut rays, &offered, |rays| match rays {
                    ShadowRays::Exact => "from every sample".into(),
                    ShadowRays::Few(count) => format!("{count} a pixel"),
                });
            });
            set(&mut settings.shadow_rays, rays, usual.shadow_rays);
            let mut surface = settings.shading.unwrap_or(usual.shading);
            ui.horizontal(|ui| {
                ui.label("Shading");
                ui.selectable_value(&mut surface, SurfaceShading::Flat, "flat");
                ui.selectable_value(&mut surface, SurfaceShading::Gradient, "gradient");
            });
            set(&mut settings.shading, surface, usual.shading);
        });
    });
    number(ui, "Ambient", &mut settings.ambient, usual.ambient, 0.0..=1.0, false);
    number(ui, "Step (voxels)", &mut settings.step, usual.step, 0.1..=4.0, true);
    ui.horizontal(|ui| {
        ui.label("Background");
        let mut colour = settings.background.unwrap_or(usual.background);
        if colour_button(ui, &mut colour) {
            settings.background = Some(colour);
        }
    });
    let mut integration = settings.integration.unwrap_or(usual.integration);
    ui.horizontal(|ui| {
        ui.label("Integration");
        ui.selectable_value(&mut integration, Integration::Fine, "fine");
        ui.selectable_value(&mut integration, Integration::Plain, "plain");
    });
    set(&mut settings.integration, integration, usual.integration);
}

/// Shaded ball that shows the light; dragging turns the light.
fn light_ball(ui: &mut Ui, settings: &mut RenderOverrides) {
    let (rect, response) = ui.allocate_exact_size(vec2(64.0, 64.0), Sense::click_and_drag());
    let response = response.on_hover_text("Drag to turn the light; over the picture with L held down");
    let light = settings.light.unwrap_or(RenderSettings::default().light.into());
    let mut direction = DVec3::from_array(light).normalize_or(DVec3::Y);
    if response.dragged()
        && let Some(at) = response.interact_pointer_pos()
    {
        let part = (at - rect.center()) / (0.5 * rect.width());
        let [x, y] = [f64::from(part.x), -f64::from(part.y)];
        let across = x.hypot(y);
        // Dragged beyond the edge, the light moves behind.
        let z = if across <= 1.0 { (1.0 - across * across).sqrt() } else { (1.0 - across).max(-1.0) };
        direction = DVec3::new(x, y, z).normalize_or(direction);
        settings.light = Some(direction.to_array());
    }
    ui.painter().add(Shape::mesh(ball(rect, direction.as_vec3())));
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().circle_stroke(rect.center(), 0.5 * rect.width(), edge);
}

/// Mesh of a ball that fills `rect`, lit from the view-space direction `light`.
fn ball(rect: Rect, light: Vec3) -> Mesh {
    const RINGS: u32 = 14;
    const SECTORS: u32 = 40;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for sector in 0..SECTORS {
            let across = (ring as f32 / RINGS as f32 * FRAC_PI_2).sin();
            let (sin, cos) = (sector as f32 / SECTORS as f32 * TAU).sin_cos();
            let normal = Vec3::new(across * cos, across * sin, (1.0 - across * across).max(0.0).sqrt());
            let shade = 0.15 + 0.85 * normal.dot(light).max(0.0);
            let at = rect.center() + vec2(normal.x, -normal.y) * (0.5 * rect.width());
            mesh.colored_vertex(at, Color32::from_gray((shade * 255.0) as u8));
        }
    }
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let next = (sector + 1) % SECTORS;
            let [a, b] = [sector, next].map(|sector| ring * SECTORS + sector);
            mesh.add_triangle(a, b, a + SECTORS);
            mesh.add_triangle(b, b + SECTORS, a + SECTORS);
        }
    }
    mesh
}
