use super::*;
use serde_json::Value;

fn plan(named: Named) -> Plan {
    named.config().plan().unwrap()
}

fn parameters(plan: &Plan, prefix: &str) -> usize {
    plan.parameters().iter().filter(|p| p.name.starts_with(prefix)).map(Parameter::len).sum()
}

#[test]
fn sizes_are_the_published_ones() {
    // Parameter counts that follow from the widths in docs/guide/src/internals/algorithm.md, sections 4 and 6: D
    // with and without feedback of its prediction, K, the narrow variant of the authors' release, and DeepFovea.
    let paper = plan(Named::WNetPaper);
    let all: usize = parameters(&paper, "");
    assert_eq!((all - parameters(&paper, "kernel."), parameters(&paper, "kernel.")), (917_059, 4_882));
    let alone = |config: WNetConfig| config.with(|options| options.feedback = Feedback::None).unwrap().plan();
    let without = alone(WNetConfig::paper());
    assert_eq!(parameters(&without, "") - parameters(&without, "kernel."), 915_331);
    let narrow = alone(WNetConfig::narrow());
    assert_eq!(parameters(&narrow, "kernel."), 4_274);
    assert_eq!(parameters(&narrow, "") - 4_274, 823_011);
    assert_eq!(parameters(&plan(Named::DeepFoveaOrig), ""), 3_174_691);
}

#[test]
fn macs_are_the_published_ones() {
    // Billions of multiply-adds per frame of 1280×736 pixels.
    let gmacs = |plan: &Plan| plan.macs_per_pixel() * 1280.0 * 736.0 / 1e9;
    assert!((gmacs(&plan(Named::WNetPaper)) - 255.5).abs() < 0.5, "{}", gmacs(&plan(Named::WNetPaper)));
    assert!(
        (gmacs(&plan(Named::DeepFoveaFvn)) - 152.4).abs() < 30.0,
        "{}",
        gmacs(&plan(Named::DeepFoveaFvn))
    );
}

#[test]
fn layers_read_what_was_written_before_and_write_once() {
    for named in Named::ALL {
        let plan = plan(named);
        let mut written = vec![false; plan.tensors().len()];
        let inputs = plan.inputs();
        for id in [Some(inputs.colour), inputs.mask, inputs.motion].into_iter().flatten() {
            written[id.index()] = true;
        }
        plan.states().iter().for_each(|state| written[state.previous.index()] = true);
        for layer in plan.layers() {
            assert!(layer.inputs().iter().all(|id| written[id.index()]), "{named}: {}", layer.name());
            assert!(!written[layer.output().index()], "{named}: {} writes again", layer.name());
            written[layer.output().index()] = true;
        }
        assert!(written.iter().all(|&written| written), "{named}");
        assert!(plan.states().iter().all(|state| state.next != state.previous), "{named}");
        let mut names: Vec<String> = plan.parameters().into_iter().map(|p| p.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), plan.parameters().len(), "{named}");
    }
}

#[test]
fn multiples_follow_the_depth() {
    let multiples = [Named::WNetPaper, Named::DeepFoveaFvn, Named::DeepFoveaOrig, Named::WNetFast]
        .map(|named| plan(named).multiple());
    assert_eq!(multiples, [8, 16, 32, 16]);
}

/// The configuration in `json`, with `fields` in place of its own.
fn changed(json: &str, fields: &str) -> Result<NetworkConfig, String> {
    let mut config: serde_json::Map<String, Value> = serde_json::from_str(json).unwrap();
    config.append(&mut serde_json::from_str(fields).unwrap());
    serde_json::from_value(Value::Object(config)).map_err(|error| error.to_string())
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let json = |named: Named| serde_json::to_string(&named.config()).unwrap();
    let [paper, fast, picture] = [Named::WNetPaper, Named::WNetFast, Named::DeepFoveaFvn].map(json);
    for (config, fields, problem) in [
        (&paper, r#"{"decoder":[64]}"#, "4 encoders and 1 decoders"),
        (&paper, r#"{"encoder":[0,1],"decoder":[1]}"#, "no channels"),
        (&paper, r#"{"encoder":[64],"decoder":[]}"#, "1 encoders and 0 decoders"),
        (&picture, r#"{"history":"centre"}"#, "taps for K"),
        (&paper, r#"{"accumulate":0.5}"#, "set `prefill`, or leave out `accumulate`"),
        (&paper, r#"{"filled":"centre"}"#, "set `prefill`, or leave out `filled`"),
        (&fast, r#"{"accumulate":0.0}"#, "`points` are samples"),
        (&fast, r#"{"accumulate":0.0,"points":false}"#, "every filled picture is fresh"),
        (&fast, r#"{"accumulate":1.5}"#, "give 0 to 1"),
        (&fast, r#"{"accumulate":-0.5}"#, "give 0 to 1"),
        (&fast, r#"{"reproject":false}"#, "`points` are samples"),
        (&fast, r#"{"fresh":null}"#, "a fresh picture is needed"),
        (&fast, r#"{"fresh":null,"doubt":false}"#, "`coarse` needs"),
        (&fast, r#"{"history":null,"feedback":"none"}"#, "the last picture is needed"),
        (&fast, r#"{"corrections":9}"#, "give 0 to 8"),
        (&paper, r#"{"corrections":9}"#, "give 0 to 8"),
        (&paper, r#"{"residual":true}"#, "no filled picture to add to"),
        (&picture, r#"{"addition":true}"#, "nothing of K"),
        (&fast, r#"{"residual":true}"#, "without a direct prediction"),
        (&fast, r#"{"feedback":"direct"}"#, "without a direct prediction"),
        (&paper, r#"{"direct":false}"#, "without a direct prediction"),
        (&picture, r#"{"direct":false}"#, "without a direct prediction"),
        (&fast, r#"{"kernels":false}"#, "taps for K"),
        (&paper, r#"{"direct":false,"feedback":"none","flat":"centre"}"#, "need a picture to weigh"),
        (&fast, r#"{"prefill":false}"#, "set `prefill`, or leave out `accumulate`"),
        (&paper, r#"{"coarse":true}"#, "`coarse` needs"),
        (&fast, r#"{"bypass":false}"#, "`coarse` needs"),
        (&fast, r#"{"fold":false}"#, "`coarse` needs"),
        (&fast, r#"{"confidence":true}"#, "unknown field"),
    ] {
        let found = changed(config, fields).unwrap_err();
        assert!(found.contains(problem) && !found.contains('\n'), "{fields}: {found}");
    }
    assert!(WNetConfig::fast().with(|options| options.encoder[0] = 5000).is_err());
    let nan = |options: &mut WNetOptions| {
        options.fill = options.fill.map(|fill| {
            let accumulation = fill.accumulation.map(|samples| Accumulation { weight: f32::NAN, ..samples });
            Fill { accumulation, ..fill }
        });
    };
    assert!(WNetConfig::fast().with(nan).is_err());
}

#[test]
fn files_have_one_level() {
    // A weights file that an earlier version wrote.
    let fast =
        r#"{"kind":"wnet","encoder":[16,16,32,48],"decoder":[16,16,32],"feedback":"output","kernels":true,"#
            .to_owned()
            + r#""normalisation":"squared","fold":true,"mask":true,"prefill":true,"bypass":true,"history":"centre","#
            + r#""reproject":true,"filled":"around","flat":"centre","accumulate":0.98,"points":true,"#
            + r#""fresh":"centre","coarse":true,"doubt":true,"corrections":1,"residual":false,"addition":true,"#
            + r#""recurrent":false,"direct":false}"#;
    assert_eq!(serde_json::to_string(&Named::WNetFast.config()).unwrap(), fast);
    // One from before most options.
    let paper =
        r#"{"kind":"wnet","encoder":[64,64,80,96],"decoder":[64,64,80],"feedback":"direct","kernels":true,"#
            .to_owned()
            + r#""normalisation":"squared","fold":false,"mask":false,"prefill":false,"bypass":false,"reproject":false}"#;
    assert_eq!(serde_json::from_str::<NetworkConfig>(&paper).unwrap(), Named::WNetPaper.config());
    for named in Named::ALL {
        let json = serde_json::to_string(&named.config()).unwrap();
        assert_eq!(serde_json::from_str::<NetworkConfig>(&json).unwrap(), named.config());
        assert_eq!(named.name().parse(), Ok(named));
    }
    // Options without a meaning are dropped.
    let idle = changed(&paper, r#"{"corrections":2}"#).unwrap();
    assert_eq!(idle, Named::WNetPaper.config());
}

#[test]
fn named_configurations_fit_together() {
    let all = [WNetConfig::paper(), WNetConfig::narrow(), WNetConfig::fast(), WNetConfig::deepfovea()];
    assert!(all.iter().all(|config| WNetConfig::new(config.options().clone()).is_ok()));
}

#[test]
fn a_coarse_picture_is_read_as_it_is_spread() {
    let first = |coarse: bool| {
        let json = serde_json::to_string(&Named::WNetFast.config()).unwrap();
        let plan = changed(&json, &format!(r#"{{"coarse":{coarse}}}"#)).unwrap().plan().unwrap();
        let of_first = |parameter: &&Parameter| parameter.name == "encoder.0.conv1.weight";
        let inputs = plan.parameters().iter().find(of_first).unwrap().shape[1];
        let blended = plan.layers().iter().filter(|layer| matches!(layer, Layer::Blend(_))).count();
        (inputs, blended)
    };
    // The first convolution reads 2×2 pixels of the filled picture, its weights, the last output and the fresh fill.
    // It reads one pixel of a coarse fresh fill, which has half the resolution and needs no second `Blend`.
    assert_eq!((first(false), first(true)), ((4 * (3 + 1 + 3 + 3), 2), (4 * (3 + 1 + 3) + 3, 1)));
}

#[test]
fn layers_refuse_inputs_that_do_not_fit() {
    let tensor = |channels, level| TensorSpec { name: format!("{channels} at {level}"), channels, level };
    let tensors = [tensor(3, 0), tensor(4, 0), tensor(POINT, 0), tensor(3, 1), tensor(16, 1)];
    let [picture, known, points, half, wide] = [0, 1, 2, 3, 4].map(TensorId);
    let around = |read| (read, Taps::Around);
    let filter = |features, images: &[Read]| Filter {
        name: "kernel".into(),
        features,
        expand: 2,
        images: images.iter().copied().map(around).collect(),
        output: TensorId::UNSET,
        normalisation: Normalisation::Squared,
    };
    let conv = |reads: &[Read]| Conv::new("conv", reads, 8, 3, Activation::Relu);
    let fitting: [Layer; 6] = [
        conv(&[Read::same(picture), Read::bilinear(half)]).into(),
        filter(wide, &[Read::same(picture), Read::nearest(half)]).into(),
        Spread::new(known, Some(half)).into(),
        HistoryConfidence::new(known, picture, half).into(),
        Accumulate::new(known, points, None, 0.5).into(),
        Splat::new(points).into(),
    ];
    for layer in fitting {
        assert!(layer.descriptor().check(&tensors).is_ok(), "{layer:?}");
    }
    let misfits: [Layer; 14] = [
        conv(&[Read::same(picture), Read::same(half)]).into(),
        conv(&[Read::bilinear(picture)]).into(),
        conv(&[]).into(),
        filter(wide, &[Read::same(half)]).into(),
        filter(known, &[Read::same(picture)]).into(),
        DepthToSpace::new(known).into(),
        Spread::new(picture, None).into(),
        Spread::new(known, Some(picture)).into(),
        Blend::new(known, picture).into(),
        HistoryConfidence::new(known, picture, picture).into(),
        Accumulate::new(known, picture, None, 0.5).into(),
        Part::new(known, 2, 3).into(),
        Add::new(picture, half).into(),
        Reproject::new(known, picture).into(),
    ];
    for layer in misfits {
        assert!(layer.descriptor().check(&tensors).is_err_and(|m| !m.contains('\n')), "{layer:?}");
    }
}
