//! Picture files and sequences of pictures.

use std::io::Cursor;
use std::path::Path;

use image::RgbaImage;
use meniscus::render::{RenderError, SequenceEnd, SequenceFormat, save_png, write_sequence};

fn frame(i: usize) -> RgbaImage {
    let shade = (60 * i) as u8;
    RgbaImage::from_pixel(5, 4, image::Rgba([shade, 10, 20, 255]))
}

fn write(
    target: &Path,
    format: SequenceFormat,
    stop_at: usize,
) -> Result<SequenceEnd, RenderError> {
    write_sequence(target, format, |i| Ok(frame(i)), 3, 10.0, &|i, count| {
        assert_eq!(count, 3);
        i < stop_at
    })
}

fn files(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).expect("readable");
    let mut names: Vec<String> = names
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn numbered_pictures_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let target = folder.path().join("turn.png");
    let end = write(&target, SequenceFormat::Png, 9).expect("written");
    let SequenceEnd::Written(paths) = end else {
        panic!("not cancelled");
    };
    assert_eq!(
        files(folder.path()),
        ["turn-0000.png", "turn-0001.png", "turn-0002.png"]
    );
    for (i, path) in paths.iter().enumerate() {
        assert_eq!(image::open(path).expect("a picture").to_rgba8(), frame(i));
    }
}

#[test]
fn animations_hold_all_pictures() {
    use image::AnimationDecoder as _;
    let folder = tempfile::tempdir().expect("a folder");
    let gif = folder.path().join("a.gif");
    write(&gif, SequenceFormat::Gif, 9).expect("written");
    let bytes = std::fs::read(&gif).expect("readable");
    let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(bytes)).expect("a gif");
    let found = decoder.into_frames().collect_frames().expect("sound");
    assert_eq!(found.len(), 3);
    for (i, f) in found.iter().enumerate() {
        assert_eq!(f.delay().numer_denom_ms(), (100, 1));
        assert_eq!(f.buffer(), &frame(i));
    }
    let apng = folder.path().join("a.png");
    write(&apng, SequenceFormat::Apng, 9).expect("written");
    let bytes = std::fs::read(&apng).expect("readable");
    let mut reader = png::Decoder::new(Cursor::new(bytes))
        .read_info()
        .expect("a png");
    let count = reader
        .info()
        .animation_control
        .expect("animated")
        .num_frames;
    assert_eq!(count, 3);
    for i in 0..3 {
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut pixels).expect("a frame");
        assert_eq!(pixels, frame(i).into_raw());
    }
}

#[test]
fn nothing_is_left_of_what_is_cancelled_or_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    for format in [
        SequenceFormat::Png,
        SequenceFormat::Gif,
        SequenceFormat::Apng,
    ] {
        for stop_at in [0, 2] {
            let end = write(&folder.path().join("x.png"), format, stop_at);
            assert_eq!(end.expect("no error"), SequenceEnd::Cancelled);
        }
        let fails = |i: usize| {
            if i < 2 {
                return Ok(frame(i));
            }
            Err(RenderError::Device {
                reason: "broken".into(),
            })
        };
        let target = folder.path().join("x.png");
        let end = write_sequence(&target, format, fails, 3, 10.0, &|_, _| true);
        let error = end.expect_err("the device broke").to_string();
        assert!(error.contains("broken"), "{error}");
        assert_eq!(files(folder.path()), [""; 0]);
    }
    let missing = folder.path().join("no/such/folder/x.png");
    let error = save_png(&missing, &frame(0)).expect_err("no folder");
    assert!(error.to_string().contains("no/such/folder"), "{error}");
}
