//! Line plots as SVG, with logarithmic axes where asked.

/// One line: its name and its points.
pub(crate) type Line = (String, Vec<(f64, f64)>);

/// What is drawn.
pub(crate) struct Plot<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    pub(crate) log_x: bool,
    pub(crate) log_y: bool,
    pub(crate) lines: &'a [Line],
}

const COLOURS: [&str; 9] =
    ["#d62728", "#1f77b4", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"];
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 460.0;
const MARGINS: [f64; 4] = [80.0, 40.0, 190.0, 60.0]; // left, top, right, bottom

impl Plot<'_> {
    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let (xs, ys) = (self.axis(self.log_x, |p| p.0), self.axis(self.log_y, |p| p.1));
        let [left, top, right, bottom] = MARGINS;
        let at_x = |v: f64| left + (WIDTH - left - right) * xs.place(v);
        let at_y = |v: f64| HEIGHT - bottom - (HEIGHT - top - bottom) * ys.place(v);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
             font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text x=\"{left}\" y=\"22\" font-size=\"15\">{}</text>\n",
            self.title
        );
        for v in xs.ticks() {
            let (x, y) = (at_x(v), HEIGHT - bottom);
            svg += &format!(
                "<path d=\"M{x:.1} {top}V{y}\" stroke=\"#ddd\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                y + 18.0,
                label(v)
            );
        }
        for v in ys.ticks() {
            let y = at_y(v);
            svg += &format!(
                "<path d=\"M{left} {y:.1}H{}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
                WIDTH - right,
                left - 6.0,
                y + 4.0,
                label(v)
            );
        }
        let middle = (left + WIDTH - right) / 2.0;
        svg += &format!("<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", HEIGHT - 14.0, self.x);
        svg += &format!(
            "<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
            HEIGHT / 2.0,
            self.y
        );
        for (i, (name, points)) in self.lines.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let path: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", at_x(p.0), at_y(p.1))).collect();
            svg += &format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n",
                path.join(" ")
            );
            // A line of one point would not be seen.
            if let [p] = points[..] {
                svg +=
                    &format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/>\n", at_x(p.0), at_y(p.1));
            }
            let (x, y) = (WIDTH - right + 12.0, top + 14.0 + 18.0 * i as f64);
            svg += &format!(
                "<path d=\"M{x} {}h16\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{y}\">{name}</text>\n",
                y - 4.0,
                x + 22.0
            );
        }
        svg + "</svg>\n"
    }

    fn axis(&self, log: bool, of: impl Fn(&(f64, f64)) -> f64) -> Axis {
        let values = || self.lines.iter().flat_map(|line| line.1.iter().map(&of));
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let low = if log { low } else { low.min(0.0) };
        Axis { log, low, high: if high > low { high } else { low + 1.0 } }
    }
}

struct Axis {
    log: bool,
    low: f64,
    high: f64,
}

impl Axis {
    fn place(&self, v: f64) -> f64 {
        let scale = |v: f64| if self.log { libm::log10(v) } else { v };
        (scale(v.max(self.low)) - scale(self.low)) / (scale(self.high) - scale(self.low))
    }

    /// Four to ten round numbers.
    fn ticks(&self) -> Vec<f64> {
        if !self.log {
            let decade = libm::pow(10.0, libm::floor(libm::log10(self.high - self.low)));
            let few = [0.2, 0.5, 1.0].map(|m| m * decade).into_iter();
            let step = few.rev().find(|step| (self.high - self.low) / step >= 4.0).unwrap_or(0.1 * decade);
            return (0..=50).map(|i| i as f64 * step).filter(|v| *v <= self.high).collect();
        }
        let decades = libm::floor(libm::log10(self.low)) as i32..=libm::ceil(libm::log10(self.high)) as i32;
        let count = decades.clone().count();
        // Over few decades 2 and 5 have lines, too.
        let multiples: &[u32] = if count <= 4 { &[1, 2, 5] } else { &[1] };
        let all = decades.step_by(1 + count / 10).flat_map(|d| multiples.iter().map(move |m| format!("{m}e{d}")));
        let numbers = all.map(|text| text.parse::<f64>().expect("a number"));
        numbers.filter(|v| (self.low..=self.high).contains(v)).collect()
    }
}

fn label(v: f64) -> String {
    if v == 0.0 || (0.01..100_000.0).contains(&v.abs()) {
        // Without the last digits of 0.1 + 0.2.
        format!("{v:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{v:.0e}")
    }
}
