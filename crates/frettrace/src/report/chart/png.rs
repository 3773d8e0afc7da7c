//! Dots to PNG files: drawn fine, then made coarser, so that edges are smooth.

/// Dots of the drawing, along each side, that make one of the file.
const COARSER: usize = 2;

/// A PNG file of red, green and blue dots of a drawing; both sides are multiples of [`COARSER`].
pub(super) fn encoded(dots: &[u8], (width, height): (u32, u32)) -> Vec<u8> {
    let [across, down] = [width, height].map(|side| side as usize / COARSER);
    let mut coarse = Vec::with_capacity(3 * across * down);
    for y in 0..down {
        for x in 0..across {
            for colour in 0..3 {
                coarse.push(mean(dots, width as usize, [COARSER * x, COARSER * y], colour));
            }
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, across as u32, down as u32);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&coarse));
    debug_assert!(written.is_ok(), "writing into memory cannot fail");
    file
}

/// Mean of a square of dots.
fn mean(dots: &[u8], width: usize, [left, top]: [usize; 2], colour: usize) -> u8 {
    let square = (0..COARSER).flat_map(|dy| (0..COARSER).map(move |dx| [left + dx, top + dy]));
    let sum: usize = square.map(|[x, y]| usize::from(dots[3 * (y * width + x) + colour])).sum();
    (sum / (COARSER * COARSER)) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What was drawn is read back, each dot the mean of four.
    #[test]
    fn a_file_holds_the_means() {
        // 4 × 2 dots: black and white on the left, one grey on the right.
        let dots: Vec<u8> =
            [0, 255, 90, 90, 255, 0, 90, 90].iter().flat_map(|grey| [*grey, *grey, 10]).collect();
        let file = encoded(&dots, (4, 2));
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut found = vec![0; 6];
        let frame = reader.next_frame(&mut found).unwrap();
        assert_eq!((frame.width, frame.height), (2, 1));
        // (0 + 255 + 255 + 0)/4, cut to whole numbers.
        assert_eq!(found, [127, 127, 10, 90, 90, 10]);
    }
}
