//! Short runs of the fuzz targets on any Rust: seeds with random changes from a fixed stream.
//!
//! `MENISCUS_FUZZ_SECONDS` is how long each target runs (default 3). `fuzz/` has the same targets for
//! cargo-fuzz, which follows the branches of the code and finds more.

mod mutate;
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use meniscus::io::{self, Format, OutputMesh};
use meniscus::mesh::{Attributes, color_columns};
use meniscus::random::SplitMix;
use meniscus::shapes;

use targets::Target;

/// Inputs longer than this only make the target slow.
const MAX_BYTES: usize = 1 << 14;

/// Runs a target on changed seeds until its time is over.
///
/// # Panics
/// If the target panics. The input is saved in the folder for temporary files of the tests.
fn fuzz(name: &str, target: Target, seeds: &[Vec<u8>], words: &[&str]) {
    let seconds = std::env::var("MENISCUS_FUZZ_SECONDS")
        .ok()
        .and_then(|s| s.parse().ok());
    let end = Instant::now() + Duration::from_secs_f64(seconds.unwrap_or(3.0));
    for seed in seeds {
        target(seed);
    }
    let mut runs = 0u64;
    while Instant::now() < end {
        let mut random = SplitMix::new(runs);
        let mut input = seeds[random.below(seeds.len())].clone();
        mutate::mutate(&mut input, seeds, words, &mut random);
        input.truncate(MAX_BYTES);
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| target(&input))) {
            let path = format!("{}/fuzz-{name}-{runs}", env!("CARGO_TARGET_TMPDIR"));
            std::fs::write(&path, &input).expect("the folder takes files");
            println!("the input that panics: {path}");
            std::panic::resume_unwind(panic);
        }
        runs += 1;
    }
    println!("{name}: {runs} runs");
    assert!(runs > 100, "{name}: only {runs} runs");
}

/// Small meshes, open and closed, with colours, as files.
fn mesh_files(format: Format) -> Vec<Vec<u8>> {
    let open = shapes::cut_where(&shapes::icosphere(3), |p| p.z > 0.6);
    [shapes::icosphere(1), open]
        .iter()
        .map(|(positions, triangles)| {
            let colors = vec![[0.5, 0.25, 1.0, 1.0]; positions.len()];
            let attributes = Attributes {
                vertices: color_columns(&colors),
                ..Attributes::default()
            };
            let mesh = OutputMesh {
                positions,
                triangles,
                attributes: &attributes,
            };
            let mut bytes = Vec::new();
            io::write(format, &mesh, &mut bytes).expect("a vector takes everything");
            bytes
        })
        .collect()
}

fn with_texts(mut seeds: Vec<Vec<u8>>, texts: &[&str]) -> Vec<Vec<u8>> {
    seeds.extend(texts.iter().map(|text| text.as_bytes().to_vec()));
    seeds
}

#[test]
fn obj() {
    let texts = [
        "mtllib a.mtl\no one\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 1 1 1e-3\nvt 0 0\nvn 0 0 1\n\
         g left\nusemtl red\nf 1/1/1 2/1/1 3/1/1\ng right\nf -1 -2 -3\nf 1 2 4 3\n",
        "v 0 0 0 2\nv 1 0 0 1\nv 0 1 0\nv 0 1 0\nvt 0\nvt 1 0 0\nvn 0 0 1\ns 1\nf 1/1 2/2 3/1\ns off\n\
         f 1//1 4/-1/-1 2/9/0\n",
        "v 0 0 0 \\\n\nv 1.5 0 0\r\nv 0 1 0 # end\ng \\ \nf 1 2 3\nl 1 2\np 1\ns off\n",
    ];
    let words = [
        "v ", "f ", "vt ", "vn ", "s ", "g ", "o ", "usemtl ", "mtllib ", "\\\n", "/", "-", "#",
        "\t",
    ];
    fuzz(
        "obj",
        targets::obj,
        &with_texts(mesh_files(Format::Obj), &texts),
        &words,
    );
}

#[test]
fn ply() {
    let texts = [
        "ply\nformat ascii 1.0\ncomment hello\nelement vertex 4\nproperty float x\nproperty float \
         y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar \
         blue\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 \
         0\n1 0 0 0 255 0\n0 1 0 0 0 255\n1 1 0 9 9 9\n3 0 1 2\n3 1 3 2\n",
        "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 6\nproperty float x\nproperty \
         float y\nproperty float z\nproperty float s\nproperty float t\nproperty short label\nelement \
         face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty \
         int patch\nproperty char part\nend_header\n0 0 0 0 0 1\n1 0 0 1 0 1\n0 1 0 0 1 2\n1 0 0 .5 0 \
         3\n0 1 0 .5 1 4\n1 1 0 .9 1 5\n3 0 1 2 6 0 0 1 0 0 1 1 -3\n3 3 5 4 0 0 7\n",
        "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float \
         y\nproperty float z\nelement tristrips 1\nproperty list int int \
         vertex_indices\nend_header\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0",
    ];
    let words = [
        "element ",
        "property ",
        "list ",
        "uchar ",
        "int ",
        "float ",
        "double ",
        "vertex ",
        "face ",
        "end_header\n",
        "ascii",
        "binary_little_endian",
        "vertex_index",
        "tristrips",
        "comment ",
        "texcoord",
        "patch",
    ];
    fuzz(
        "ply",
        targets::ply,
        &with_texts(mesh_files(Format::Ply), &texts),
        &words,
    );
}

#[test]
fn stl() {
    let texts = [
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 \
         0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 \
         1 0\nendloop\nendfacet\nendsolid a\n",
        "solid\nendsolid\nsolid b\nendsolid b\n",
    ];
    let words = [
        "solid ",
        "facet normal ",
        "outer loop\n",
        "vertex ",
        "endloop\n",
        "endfacet\n",
    ];
    fuzz(
        "stl",
        targets::stl,
        &with_texts(mesh_files(Format::Stl), &texts),
        &words,
    );
}

#[test]
fn off() {
    let texts = [
        "STCNOFF 4 2 0\n0 0 0 0 0 1 1 0 0 1 0 0\n1 0 0 0 0 1 0 1 0 1 .5 0\n1 1 0 0 0 1 0 0 1 1 .5 .5\n\
         0 1 0 0 0 1 0 0 0 1 0 .5\n3 0 1 2 255 0 0\n4 0 1 2 3 0 0 255\n",
        "OFF\n# a comment\n4 2\n0 0 0\n1 0 0\n1 1e-3 0\n0 1 0\n3 0 1 2 1\n3 0 2 3 2\n",
    ];
    let words = [
        "OFF", "COFF", "NOFF", "STOFF", "BINARY", "#", "3 ", "4 ", "\n",
    ];
    fuzz(
        "off",
        targets::off,
        &with_texts(mesh_files(Format::Off), &texts),
        &words,
    );
}

#[test]
fn gltf() {
    let texts = [
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],
        "translation":[1,0,0]},{"mesh":0,"rotation":[0,0,1,0],"scale":[1,-1,1]}],"meshes":[{"primitives":
        [{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},"mode":5,"material":0}]}],"materials":
        [{"name":"a"}],"images":[{"bufferView":0}],"buffers":[{"byteLength":48,"uri":
        "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAA"}],"bufferViews":
        [{"buffer":0,"byteLength":48}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,
        "type":"VEC3"},{"bufferView":0,"componentType":5123,"normalized":true,"count":4,"type":"VEC2"},
        {"bufferView":0,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}]}"#,
    ];
    let words = [
        "\"nodes\":",
        "\"mesh\":0",
        "\"children\":[0]",
        "\"mode\":6",
        "\"count\":",
        "\"byteStride\":",
        "\"indices\":1",
        "\"NORMAL\":0",
        "\"uri\":",
        "\"byteOffset\":",
        "5125",
        "18446744073709551615",
        "1e39",
        "JSON",
        "[",
        "]",
        "{",
        "}",
        ",",
    ];
    let files = [mesh_files(Format::Glb), mesh_files(Format::Gltf)].concat();
    fuzz("gltf", targets::gltf, &with_texts(files, &texts), &words);
}

#[test]
fn threemf() {
    let texts = [
        r##"<model unit="inch" xmlns="core" xmlns:m="materials"><metadata name="Title">a &lt; b</metadata>
        <resources><basematerials id="1"><base name="a" displaycolor="#FF8000"/></basematerials>
        <m:colorgroup id="2"><m:color color="#FF0000"/><m:color color="#00FF0080"/></m:colorgroup>
        <m:texture2dgroup id="3" texid="9"><m:tex2coord u="0" v=".5"/></m:texture2dgroup>
        <object id="4" name="one" pid="1" pindex="0"><mesh><vertices><vertex x="0" y="0" z="0"/>
        <vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>
        <triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="3" v3="1" pid="2" p1="0" p2="1"
        p3="1"/><triangle v1="0" v2="2" v3="3" pid="3" p1="0"/></triangles></mesh></object>
        <object id="5" type="model"><components><component objectid="4"/><component objectid="4"
        transform="-1 0 0 0 1 0 0 0 1 5 0 0"/></components></object></resources>
        <build><item objectid="5"/><item objectid="4" transform="1 0 0 0 1 0 0 0 1 0 9 0"/></build></model>"##,
    ];
    let words = [
        "<object id=\"6\">",
        "<component objectid=\"5\"/>",
        "<item objectid=\"4\"/>",
        "<mesh>",
        "</mesh>",
        "pid=\"2\"",
        "p1=\"1\"",
        "path=\"/3D/3dmodel.model\"",
        "transform=\"",
        "<!--",
        "<![CDATA[",
        "&amp;",
        "1e999",
        "/>",
        ">",
        "\"",
    ];
    let seeds = with_texts(mesh_files(Format::ThreeMf), &texts);
    fuzz("threemf", targets::threemf, &seeds, &words);
}

#[test]
fn expressions() {
    let texts = [
        "H^2+K^2",
        "k1^4+k2^4",
        "(H-H0)^2",
        "sqrt(k1^2+k2^2+a^2)",
        "max(H,-H)^2 + a*K^2",
        "abs(k1-k2)^3/(1+exp(-H))",
        "min(k1,k2)*max(k1,k2)",
        "log(2+tanh(H))^sin(K)*cos(a)",
    ];
    let words = [
        "H", "K", "k1", "k2", "a", "H0", "+", "-", "*", "/", "^", "(", ")", ",", "sqrt(", "abs(",
        "exp(", "log(", "sin(", "cos(", "tanh(", "min(", "max(", "²", "κ",
    ];
    fuzz(
        "expression",
        targets::expression,
        &with_texts(Vec::new(), &texts),
        &words,
    );
}

#[test]
fn schedules() {
    let texts = [
        "attempt,control,value\n3,energy,H^2+K^2\n6,rewind,2\n9,stop,\n",
        "attempt,control,value\n1,continuity,g0\n1,loop-continuity,2=g1\n4,tension,2\n4,tau,1e-4\n",
        "attempt,control,value\n1,energy,\"max(H,-H)^2\"\n2,param,a=0.5\n2,density,1.5\n5,finish,\n",
    ];
    let words = [
        "energy",
        "param",
        "scheme",
        "mixed",
        "mode",
        "flow",
        "linear",
        "lu",
        "tau",
        "auto",
        "growth",
        "relaxation",
        "bulge",
        "noise",
        "steps",
        "rewind",
        "finish",
        "stop",
        "\"",
        ",",
        "\n",
        "\r",
        "\r\n",
        "=",
    ];
    fuzz(
        "schedule",
        targets::schedule,
        &with_texts(Vec::new(), &texts),
        &words,
    );
}

#[cfg(feature = "window")]
#[test]
fn projects() {
    let head = "version = 1\nopened = [4, 3]\nselection = [0]\nselected_faces = \"1-2\"\n";
    let view = "[view]\ncamera = \"1,2,3,0,0.6,0,0.8,5,40,persp\"\nmode = \"zebra\"\nstripes = \
                12\nlight = [0.3, 1.0, 0.5]\nrange = [-2.0, 2.0]\nwireframe = true\ntint = \
                true\nlimit_surface = true\nrims = false\n[controls]\nenergy = \
                \"H^2\"\ndensity = 1.5\n";
    let done = "[[fills]]\ntask = \"blend\"\nloops = [1, 2]\nfaces = [1, 3]\nschedule = \
                \"attempt,control,value\\n3,energy,K^2\\n\"\n[fills.controls]\nenergy = \
                \"H^2+K^2\"\n[[fills]]\ntask = \"bridge\"\nends = [[0.0, 0.0, 1.0], [1.0, 0.0, \
                0.0]]\nwidth = 2\nfaces = [0, 2]\nschedule = \
                \"attempt,control,value\\n\"\n[fills.controls]\n";
    let texts = [
        format!("{head}{view}"),
        format!("{head}first_patch_face = 1\n{view}{done}"),
    ];
    for text in &texts {
        let read = meniscus::app::rewrite_project(&targets::with_mesh(text));
        assert!(read.is_ok(), "{read:?}");
    }
    let words = [
        "task = \"erase\"\n",
        "task = \"flip\"\n",
        "task = \"refine\"\n",
        "task = \"fair\"\n",
        "sample = \"three-y\"\n",
        "mesh = \"no.obj\"\n",
        "selected = \"1-3\"\n",
        "[[fills]]\n",
        "[fills.controls]\n",
        "[view]\n",
        "nan",
        "inf",
        "\"\"\"",
        "\\n",
        "\"",
        "= ",
        "[",
        "]",
    ];
    let seeds = texts.map(String::into_bytes);
    fuzz("project", targets::project, &seeds, &words);
}
