//! Sound transfer functions of every program, as small as they can be and still use every feature.

/// All of them.
pub fn all() -> Vec<Vec<u8>> {
    SEEDS.iter().map(|text| text.as_bytes().to_vec()).collect()
}

const SEEDS: &[&str] = &[
    r#"{"points":[[0,0,0,0,0],[0.5,1,0.5,0,0.2],[1,1,1,1,1]]}"#,
    r#"{"range":[-1000,3000],"points":[[-1000,0,0,0,0],[200,1,0.5,0,0.2],[3000,1,1,1,1]]}"#,
    r#"{"range":[-10,30],"points":[[-10,0,0,0,0],[30,1,1,1,1]],"gradient":[[0,0],[2.5,0.5],[2.5,0.8],[9,1]]}"#,
    r#"[{"Name":"a","ColorSpace":"Lab","NanColor":[1,1,0],"NanOpacity":0.5,"RGBPoints":[-100,0,0,0, 50,0.2,0.9,0.1, 300,1,1,1],
        "Points":[-50,0,0.2,0, 20,0.8,0.7,0.5, 90,0.1,0.5,1],},]"#,
    r#"[{"Name":"b","ColorSpace":"Step","UseLogScale":1,"RGBPoints":[0.01,0,0,0, 1,1,0,0, 1000,1,1,1]},
        {"Name":"c","ColorSpace":"HSV","HSVWrap":1,"RGBPoints":[0,1,0,0, 1,0,0,1]},
        {"Name":"d","ColorSpace":"Lab/CIEDE2000","RGBPoints":[0,1,0,0, 1,0,0,1]},
        {"Name":"e","ColorSpace":"Diverging","RGBPoints":[-1,0.2,0.3,0.8, 1,0.7,0,0.1]},
        {"Name":"f","ColorSpace":"Prolab","UseLogScaleOpacity":1,"RGBPoints":[1,1,0,0, 9,0,0,1],"Points":[1,0,0.5,0, 9,1,0.5,0]}]"#,
    r#"{"ColorSpace":"Lab/CIEDE2000","RGBPoints":[0,1,0,0, 1,0,0,1]}"#,
    r#"{"ColorSpace":"RGB","UseLogScale":1,"RGBPoints":[0.01,0,0,0, 1,1,0,0, 1000,1,1,1]}"#,
    r#"[{"Name":"tissue","Annotations":["1","liver","3","bone","none",""],"IndexedColors":[1,0,0, 0,0,1, 0,1,0],"IndexedOpacities":[0.8,0.8,0]}]"#,
    r#"{"name":"CT","scalarOpacity":"8 -1000 0 152.19 0 278.93 0.19 952 0.2","gradientOpacity":"6 -5 0 20 0.5 255 1",
        "colorTransfer":"8 -1000 0.3 0.3 1 3000 1 1 1","interpolation":"1","shade":"1"}"#,
    r#"<MRML><VolumeProperty id="x" name="CT-Bone" gradientOpacity="4 0 1 255 1" scalarOpacity="4 0 0 9 1" colorTransfer="8 0 0 0 0 9 1 1 1"/>
        <VolumeProperty name="b" scalarOpacity="4 0 0 5 1" colorTransfer="8 0 0 0 0 5 1 1 1"/></MRML>"#,
    r#"<?xml version="1.0" ?><InviwoTransferFunction version="1"><maskMin content="0.1"/><maskMax content="0.9"/><type content="1"/>
        <interpolationMethod content="0"/><Points><Point><pos content="-1000"/><rgba x="0" y="0" z="0" w="0.5"/></Point>
        <Point><pos content="3000"/><rgba x="1" y="1" z="1" w="0.5"/></Point></Points></InviwoTransferFunction>"#,
    r#"<InviwoWorkspace version="2"><Points><Point><pos content="0.25" /><rgba x="0.1" y="0.2" z="0.3" w="0" /></Point>
        <Point><pos content="0.75" /><rgba x="0.5" y="0.6" z="0.7" w="0.8" /></Point></Points></InviwoWorkspace>"#,
    "1\n10\n0.2\n0.1\n0.9\n1\n8 -1000 0 152.19 0 278.93 0.19 952 0.2\n4 0 1 255 1\n8 -1000 0.3 0.3 1 3000 1 1 1\n",
    "# r g b\n0 0 0\n0.5 0.25 0\n1 1 1\n",
    "0,0,0,0\n128,64,0,30\n255,255,255,255\n",
];
