//! Curves over axes with round ticks, as SVG.

use std::io::{self, Write};

/// A plot of a few curves; the y axis begins at 0.
pub struct Plot {
    /// Title above the axes.
    pub title: &'static str,
    /// Label of the x axis, with its unit.
    pub x: &'static str,
    /// Label of the y axis.
    pub y: &'static str,
    /// Whether the x axis is logarithmic.
    pub log_x: bool,
    /// The curves, at most three in different colours.
    pub curves: Vec<Series>,
    /// Width and height, pixels.
    pub size: [f64; 2],
}

/// A named curve, or dots.
pub struct Series {
    name: &'static str,
    points: Vec<(f64, f64)>,
    dots: bool,
}

/// Colours that differ for every eye (Okabe and Ito 2008).
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];
/// Margins, pixels.
const LEFT: f64 = 48.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 40.0;
/// Width of a curve's name with its colour, and height of its line, pixels.
const LEGEND: f64 = 96.0;
const ROW: f64 = 15.0;

impl Series {
    /// A line through `points`.
    pub fn line(name: &'static str, points: Vec<(f64, f64)>) -> Self {
        Self { name, points, dots: false }
    }

    /// A dot at each of `points`.
    pub fn dots(name: &'static str, points: Vec<(f64, f64)>) -> Self {
        Self { name, points, dots: true }
    }

    /// Where the curve runs, at most 4 pixels from one point to the next unless they are dots.
    fn pixels(&self, x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
        let at = self.points.iter().map(|&(px, py)| (x.at(px), y.at(py)));
        let at: Vec<(f64, f64)> = at.filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let between = |ends: &[(f64, f64)]| {
            let [(ax, ay), (bx, by)] = [ends[0], ends[1]];
            let steps =
                if self.dots { 1 } else { ((bx - ax).abs().max((by - ay).abs()) / 4.0).ceil().max(1.0) as usize };
            (1..=steps).map(move |i| i as f64 / steps as f64).map(move |s| (ax + s * (bx - ax), ay + s * (by - ay)))
        };
        at.iter().take(1).copied().chain(at.windows(2).flat_map(between)).collect()
    }
}

/// The part of an axis that is shown, and where its ends lie, pixels.
struct Axis {
    from: f64,
    to: f64,
    pixels: [f64; 2],
    log: bool,
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        let scaled = |x: f64| if self.log { libm::log(x) } else { x };
        let share = (scaled(value) - scaled(self.from)) / (scaled(self.to) - scaled(self.from));
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Round values within the axis, about five.
    fn ticks(&self) -> Vec<f64> {
        let rough = (self.to - self.from) / 5.0;
        let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough);
        let first = (self.from / step).ceil() as i64;
        (first..first + 20).map(|i| i as f64 * step).take_while(|&x| x <= self.to * (1.0 + 1e-9)).collect()
    }
}

impl Plot {
    /// Width and height of a plot that stands beside others, pixels.
    pub const SMALL: [f64; 2] = [350.0, 260.0];

    /// Writes the plot as SVG; its classes `f` and `g` are the frame and the grid.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let [width, height] = self.size;
        writeln!(
            out,
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"><text x=\"{LEFT}\" y=\"14\">{}</text>",
            self.title
        )?;
        let Some((x, y)) = self.axes() else {
            return writeln!(out, "<text x=\"{LEFT}\" y=\"60\">nothing to show</text></svg>");
        };
        self.frame(&x, &y, out)?;
        let at = self.legend(&x, &y);
        for (i, curve) in self.curves.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            draw(curve, colour, &x, &y, out)?;
            let (tx, ty) = (at.0, at.1 + 11.0 + ROW * i as f64);
            writeln!(out, "<rect x=\"{tx}\" y=\"{}\" width=\"14\" height=\"3\" fill=\"{colour}\"/>", ty - 5.0)?;
            writeln!(out, "<text x=\"{}\" y=\"{ty}\">{}</text>", tx + 19.0, curve.name)?;
        }
        writeln!(out, "</svg>")
    }

    /// Axes around all points, if there are any.
    fn axes(&self) -> Option<(Axis, Axis)> {
        let points =
            || self.curves.iter().flat_map(|curve| &curve.points).filter(|p| p.0.is_finite() && p.1.is_finite());
        let from = points().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let to = points().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
        let top = points().map(|p| p.1).fold(0.0, f64::max) * 1.04;
        let [width, height] = self.size;
        let x = Axis { from, to, pixels: [LEFT, width - RIGHT], log: self.log_x };
        let y = Axis { from: 0.0, to: top, pixels: [height - BOTTOM, TOP], log: false };
        (from < to && top > 0.0).then_some((x, y))
    }

    /// The upper left corner of the curves' names: in the corner of the axes that holds the least of the curves, pixels.
    fn legend(&self, x: &Axis, y: &Axis) -> (f64, f64) {
        let [wide, high] = [LEGEND, ROW * self.curves.len() as f64];
        let (left, right) = (x.pixels[0] + 8.0, x.pixels[1] - wide);
        let (top, bottom) = (y.pixels[1] + 4.0, y.pixels[0] - high - 4.0);
        let hidden = |&(at_x, at_y): &(f64, f64)| {
            let is_below = |&(px, py): &(f64, f64)| {
                (at_x - 4.0..at_x + wide).contains(&px) && (at_y - 4.0..at_y + high + 4.0).contains(&py)
            };
            self.curves.iter().flat_map(|curve| curve.pixels(x, y)).filter(is_below).count()
        };
        let corners = [(right, bottom), (right, top), (left, top), (left, bottom)];
        corners.into_iter().min_by_key(hidden).unwrap_or(corners[0])
    }

    fn frame(&self, x: &Axis, y: &Axis, out: &mut impl Write) -> io::Result<()> {
        let [[left, right], [bottom, top]] = [x.pixels, y.pixels];
        for value in y.ticks() {
            let at = y.at(value);
            writeln!(out, "<path class=\"g\" d=\"M{left} {at:.1}H{right}\"/>")?;
            writeln!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 5.0,
                at + 4.0,
                short(value)
            )?;
        }
        for value in x.ticks() {
            let at = x.at(value);
            writeln!(out, "<path class=\"g\" d=\"M{at:.1} {bottom}V{top}\"/>")?;
            writeln!(
                out,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                bottom + 15.0,
                short(value)
            )?;
        }
        writeln!(out, "<path class=\"f\" d=\"M{left} {top}V{bottom}H{right}\"/>")?;
        let (middle, below) = ((left + right) / 2.0, bottom + 32.0);
        writeln!(out, "<text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{}</text>", self.x)?;
        let centre = (top + bottom) / 2.0;
        writeln!(out, "<text transform=\"translate(12 {centre}) rotate(-90)\" text-anchor=\"middle\">{}</text>", self.y)
    }
}

fn draw(curve: &Series, colour: &str, x: &Axis, y: &Axis, out: &mut impl Write) -> io::Result<()> {
    let points = curve.points.iter().filter(|p| p.1.is_finite()).map(|&(px, py)| (x.at(px), y.at(py)));
    if curve.dots {
        for (px, py) in points {
            writeln!(out, "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"3.5\" fill=\"{colour}\"/>")?;
        }
        return Ok(());
    }
    write!(out, "<polyline fill=\"none\" stroke-width=\"1.8\" stroke=\"{colour}\" points=\"")?;
    for (px, py) in points {
        write!(out, "{px:.1},{py:.1} ")?;
    }
    writeln!(out, "\"/>")
}

/// A tick's number without the digits that multiplying left behind.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text as HTML shows it.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let axis = Axis { from: 5.0, to: 20.0, pixels: [0.0, 100.0], log: true };
        assert_eq!(axis.ticks(), [5.0, 10.0, 15.0, 20.0]);
        let axis = Axis { from: 0.0, to: 0.52, pixels: [100.0, 0.0], log: false };
        assert_eq!(axis.ticks().into_iter().map(short).collect::<Vec<_>>(), ["0", "0.2", "0.4"]);
        assert_eq!((axis.at(0.0), axis.at(0.52)), (100.0, 0.0));
    }

    #[test]
    fn names_stand_where_no_curve_runs() {
        let plot = |curves: &[&[(f64, f64)]]| Plot {
            title: "",
            x: "",
            y: "",
            log_x: false,
            curves: curves.iter().map(|points| Series::line("a", points.to_vec())).collect(),
            size: Plot::SMALL,
        };
        let corner = |curves: &[&[(f64, f64)]]| {
            let plot = plot(curves);
            let (x, y) = plot.axes().unwrap();
            let at = plot.legend(&x, &y);
            (at.0 > Plot::SMALL[0] / 2.0, at.1 > Plot::SMALL[1] / 2.0)
        };
        let [rising, falling]: [&[(f64, f64)]; 2] = [&[(0.0, 0.0), (1.0, 1.0)], &[(0.0, 1.0), (1.0, 0.0)]];
        assert_eq!(corner(&[rising]), (true, true));
        assert_eq!(corner(&[falling]), (true, false));
    }

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escape("<b> & </b>"), "&lt;b&gt; &amp; &lt;/b&gt;");
    }
}
