use super::*;

fn chart<'a>(x: &'a [f64], y: &'a [f64]) -> Chart<'a> {
    let curves = vec![Curve::line("measured", Role::Measured, x, y)];
    Chart { title: "a <loop>", x_label: "slip [m]", y_label: "force [N]", logarithmic: false, curves }
}

/// No marker colour is left, and the page's picture takes its colours from the page.
#[test]
fn colours_belong_to_the_page() {
    let (x, y) = ([0.0, 1.0, 2.0], [0.0, 1.0, 0.5]);
    let page = chart(&x, &y).picture(Ink::Page).svg;
    assert!(page.contains("var(--measured)") && page.contains("var(--paper)"), "{page}");
    assert!(!page.contains("#0") && page.contains("a &lt;loop&gt;"), "{page}");
    assert!(chart(&x, &y).picture(Ink::File).svg.contains("#FFFFFF"));
}

/// A gap cuts the line in two; nothing that is not a number reaches the picture.
#[test]
fn a_gap_cuts_the_line() {
    let svg = chart(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0, 1.0, f64::NAN, 1.0, 0.0]).picture(Ink::File).svg;
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert_eq!(pieces(&[(0.0, 0.0), (1.0, f64::NAN), (2.0, 0.0)]).count(), 2);
}

/// Eight levels have eight colours, all of them in the picture, and eight names beside no data.
#[test]
fn eight_levels_are_told_apart() {
    let (x, y) = ([0.0, 1.0], [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [3.0, 4.0]]);
    let names: Vec<String> = (0..8).map(|level| format!("level {level}")).collect();
    let curves = (0..8)
        .map(|level| Curve::line(&names[level], Role::Number(level), &x, &y[level % y.len()]))
        .collect();
    let chart = Chart { curves, ..chart(&x, &y[0]) };
    let svg = chart.picture(Ink::File).svg;
    let drawn = |c: &RGBColor| svg.contains(&format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2));
    assert!(ink::NUMBERED.iter().all(drawn), "{svg}");
    let (entries, height) = chart.legend();
    assert_eq!(entries.len(), 8);
    // Eight names of seven letters (23 + 49 + 14 pixels each) go five to a row of 456 pixels.
    assert_eq!((entries[5].place.1, height), (LINE, 2 * LINE));
    assert!(entries.iter().all(|e| e.place.0 + STROKE + 5 + width(&e.name, LETTER) <= WIDTH));
}

#[test]
fn an_empty_chart_still_draws() {
    assert!(chart(&[], &[]).picture(Ink::File).svg.contains("</svg>"));
    let rows = Rows { title: "evidence", x_label: "1", rows: Vec::new() };
    assert!(rows.picture(Ink::File).svg.contains("</svg>"));
}

/// The rectangles of an SVG in one colour: x, y, width, height in pixels.
fn rectangles(svg: &str, colour: &str) -> Vec<[f64; 4]> {
    let of = |tag: &str, name: &str| -> f64 {
        tag.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    svg.split("<rect")
        .skip(1)
        .map(|tag| tag.split("/>").next().unwrap())
        .filter(|tag| tag.contains(colour))
        .map(|tag| ["x", "y", "width", "height"].map(|name| of(tag, name) / f64::from(FINE)))
        .collect()
}

/// Bars are as long as their values, the first on top; one that is not finite is left out and its name stays.
#[test]
fn bars_are_as_long_as_their_values() {
    let row = |name: &str, value: f64| Row::bar(name.into(), Role::After, value, format!("{value}"));
    let rows = vec![row("friction.lag", 40.0), row("friction.film", 10.0), row("friction.wear", f64::NAN)];
    let svg = Rows { title: "Evidence", x_label: "evidence [1]", rows }.picture(Ink::File).svg;
    let bars = rectangles(&svg, "#0072B2");
    assert_eq!(bars.len(), 2);
    assert!(bars[0][1] < bars[1][1], "{bars:?}");
    // Ends are rounded to a quarter of a pixel: half of that at each end.
    assert!((bars[0][2] - 4.0 * bars[1][2]).abs() < 1.3, "{bars:?}");
    assert!(svg.contains("friction.wear"));
}

/// A map has a cell for every number, dark at the floor and below, light at the top; what is not known stays empty.
#[test]
fn a_map_shows_every_number() {
    let values = [vec![1.0, 0.3, 100.0], vec![f64::NAN, 10.0, 1e9]];
    let map = Map {
        title: "Residual",
        x: Axis::Numbers { label: "phase [periods]".into(), range: 0.0..1.0 },
        y: Axis::Names { label: "sensor".into(), names: vec!["0".into(), "1".into()] },
        values: &values,
        top: 100.0,
        scale: "standard deviations of the noise",
    };
    let svg = map.picture(Ink::File).svg;
    // The ends of viridis as plotters has it; the scale's own steps stop half a step short of them.
    assert_eq!(rectangles(&svg, "#440154").len() + rectangles(&svg, "#FEE825").len(), 4, "{svg}");
    assert_eq!(map.share(10.0), 0.5);
    let cells = svg.matches("<rect").count();
    // Paper, 5 cells, the scale's steps.
    assert_eq!(cells, 1 + 5 + 48);
}

/// The PNG shows what the SVG says: paper in the corner, the bar's colour in the middle of the bar, letters somewhere else.
#[test]
fn a_png_is_the_same_picture() {
    let rows = vec![Row::bar("friction.lag".into(), Role::After, 40.0, String::new())];
    let drawn = Rows { title: "Evidence für Ω", x_label: "evidence [1]", rows }.picture(Ink::FileAndPng);
    let [x, y, width, height] = rectangles(&drawn.svg, "#0072B2")[0];
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(drawn.png.unwrap())).read_info().unwrap();
    let mut dots = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut dots).unwrap();
    // Two dots a pixel.
    assert_eq!(frame.width, 2 * WIDTH as u32);
    let at = |x: f64, y: f64| {
        let first = 3 * ((2.0 * y) as usize * frame.width as usize + (2.0 * x) as usize);
        [dots[first], dots[first + 1], dots[first + 2]]
    };
    assert_eq!(at(0.0, 0.0), [255; 3]);
    assert_eq!(at(x + 0.5 * width, y + 0.5 * height), [0x00, 0x72, 0xb2]);
    // The title's letters lie in the uppermost rows: dark dots on paper.
    assert!((0..2 * WIDTH).any(|x| at(0.5 * f64::from(x), f64::from(MARGIN + 7))[0] < 100));
}
