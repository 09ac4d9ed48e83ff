//! Table: full frames compared with VTK's, as `benchmarks/peers/vtk_march.py` measured them.

use super::section::{Cell, Section};
use anyhow::{Context, Result, ensure};
use fovolnet::core::input;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Output of the script.
#[derive(Deserialize)]
struct Measured {
    /// Version of VTK.
    vtk: String,
    machine: Processor,
    size: [u32; 2],
    volume: [u32; 3],
    date: String,
    results: Vec<Case>,
}

#[derive(Deserialize)]
struct Processor {
    cpu: String,
    threads: usize,
}

/// Measurement of one volume, transfer function and shading.
#[derive(Deserialize)]
struct Case {
    case: String,
    vtk_ms: f64,
    psnr_between_pictures: f64,
    /// Times of this program with each instruction set.
    #[serde(flatten)]
    ours: BTreeMap<String, Ours>,
}

#[derive(Deserialize)]
struct Ours {
    ms: f64,
    /// Time of VTK divided by this program's.
    ratio: f64,
}

/// Adds the table from `file` to `section`.
pub fn add(section: &mut Section, file: &Path) -> Result<()> {
    let mend = || {
        format!("{} says nothing of VTK; make it with `python benchmarks/peers/vtk_march.py`", file.display())
    };
    let text = input::read_to_string(file).with_context(mend)?;
    let measured: Measured = serde_json::from_str(&text).with_context(mend)?;
    ensure!(!measured.results.is_empty(), mend());
    let ([width, height], [x, y, z]) = (measured.size, measured.volume);
    section.text.push(format!(
        "Full frames of {width}×{height} pixels of {x}×{y}×{z} voxels beside VTK {} with the same camera, transfer function \
         and step, in alternation on {} with {} threads, {}: vtkFixedPointVolumeRayCastMapper without shadows, \
         vtkGPUVolumeRayCastMapper on software OpenGL with them.",
        measured.vtk, measured.machine.cpu, measured.machine.threads, measured.date
    ));
    let columns = ["full frames", "instructions", "VTK ms", "ms", "VTK / ms", "PSNR between the pictures"];
    section.table("vtk", &columns, measured.results.iter().flat_map(rows).collect());
    Ok(())
}

fn rows(case: &Case) -> impl Iterator<Item = Vec<Cell>> {
    case.ours.iter().map(|(simd, ours)| {
        vec![
            case.case.as_str().into(),
            simd.as_str().into(),
            case.vtk_ms.into(),
            ours.ms.into(),
            ours.ratio.into(),
            case.psnr_between_pictures.into(),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"vtk": "9.7.2", "python": "3.11", "size": [1280, 720], "volume": [256, 256, 256], "step": 0.5,
        "machine": {"cpu": "one", "threads": 2, "simd": "avx2", "system": "linux", "version": "0.1.0"},
        "rounds": 3, "date": "2026-11-21", "results": [{"case": "smoke", "vtk_ms": 300.0, "psnr_between_pictures": 44.0,
        "avx2": {"ms": 60.0, "ratio": 5.0, "primary": 7}, "avx512": {"ms": 40.0, "ratio": 7.5, "primary": 7}}]}"#;

    #[test]
    fn what_the_script_writes_becomes_a_table() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("vtk_march.json");
        std::fs::write(&file, FILE).unwrap();
        let mut section = Section::new("A title", &[]);
        add(&mut section, &file).unwrap();
        let cells: Vec<String> = section.tables[0].rows[1].iter().map(ToString::to_string).collect();
        assert_eq!(cells, ["smoke", "avx512", "300.0", "40.00", "7.500", "44.00"]);
        assert!(section.text[0].contains("VTK 9.7.2") && section.text[0].contains("2026-11-21"));
        for wrong in ["", "{}", &FILE.replace("300.0", "\"slow\"")] {
            std::fs::write(&file, wrong).unwrap();
            let said = add(&mut section, &file).unwrap_err().to_string();
            assert!(said.contains("vtk_march.py"), "{said}");
        }
    }
}
