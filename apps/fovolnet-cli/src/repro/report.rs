//! Report: one HTML file that embeds all sections and their pictures, easy to send.

use super::section::{Cell, Figure, Section, Table};
use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use fovolnet::io::atomic;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::path::Path;

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: #fff }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto }
th, td { padding: .2rem .8rem; border-bottom: 1px solid #ddd; text-align: left; vertical-align: bottom }
td { white-space: nowrap }
td.number { text-align: right; font-variant-numeric: tabular-nums }
figure { margin: 1.5rem 0 }
figure img, figure video { max-width: 100%; image-rendering: auto }
figcaption, .facts { color: #555; font-size: .9rem }
nav a { margin-right: 1rem }
";

/// Reads the sections in `folder`, in the order of `names`.
pub fn sections(folder: &Path, names: &[String]) -> Result<Vec<Section>> {
    names.iter().filter_map(|name| Section::read(folder, name).transpose()).collect()
}

/// Writes `report.html` from the sections in `folder`.
pub fn write(folder: &Path, names: &[String]) -> Result<()> {
    let sections = sections(folder, names)?;
    let parts = sections.iter().map(|section| part(folder, section)).collect::<Result<Vec<_>>>()?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "FoVolNet: the evaluation" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "FoVolNet: the evaluation" }
                p {
                    "Tables and figures of Bauer, Wu and Ma, “FoVolNet: Fast Volume Rendering using Foveated Deep Neural \
                     Networks” (IEEE VIS 2022), made by this program on this machine, with the paper's figures beside them."
                }
                nav { @for section in &sections { a href={ "#" (section.name) } { (section.title) } } }
                @for part in &parts { (part) }
            }
        }
    };
    atomic::write_bytes(&folder.join("report.html"), page.into_string().as_bytes())?;
    Ok(())
}

fn part(folder: &Path, section: &Section) -> Result<Markup> {
    let pictures =
        section.figures.iter().map(|figure| embedded(folder, section, figure)).collect::<Result<Vec<_>>>()?;
    let fact = |name: &str| section.machine.get(name).map(ToString::to_string).unwrap_or_default();
    Ok(html! {
        section id=(section.name) {
            h2 { (section.title) }
            @for paragraph in &section.text { p { (paragraph) } }
            @for picture in &pictures { (picture) }
            @for table in section.shown() { (rows(table)) }
            p.facts {
                code { "fovolnet repro " (section.name) } ", " (format!("{:.0} s", section.seconds)) " on "
                (fact("cpu").trim_matches('"')) ", " (fact("threads")) " threads, " (fact("simd").trim_matches('"'))
                ", version " (fact("version").trim_matches('"'))
            }
        }
    })
}

fn rows(table: &Table) -> Markup {
    html! {
        table {
            thead { tr { @for column in &table.columns { th { (column) } } } }
            tbody {
                @for row in &table.rows {
                    tr {
                        @for cell in row {
                            @match cell {
                                Cell::Number(_) => td.number { (cell) },
                                Cell::Words(words) => td { (words) },
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Largest size in bytes of a film that the report embeds.
const LARGEST_FILM: u64 = 32 << 20;

fn embedded(folder: &Path, section: &Section, figure: &Figure) -> Result<Markup> {
    let path = folder.join(&section.name).join(&figure.file);
    let missing =
        || format!("{} is missing; make it again with `fovolnet repro {}`", path.display(), section.name);
    let data = |kind: &str| -> Result<String> {
        let bytes = std::fs::read(&path).with_context(missing)?;
        Ok(format!("data:{kind};base64,{}", STANDARD.encode(bytes)))
    };
    let length = path.metadata().with_context(missing)?.len();
    let shown = match &*path.extension().unwrap_or_default().to_string_lossy() {
        "svg" => html! { img src=(data("image/svg+xml")?) alt=(figure.caption); },
        "png" => html! { img src=(data("image/png")?) alt=(figure.caption); },
        "mp4" if length <= LARGEST_FILM => html! { video src=(data("video/mp4")?) controls loop muted {} },
        // Films in other formats do not play in browsers and may have gigabytes, so they are linked.
        _ => html! { a href={ (section.name) "/" (figure.file) } { (figure.file) } },
    };
    Ok(html! { figure { (shown) figcaption { (figure.caption) } } })
}
