//! The description of a TIFF file's pages: ImageJ's lines, OME-XML, or tifffile's shape.

use super::super::{VolumeError, xml};

const FIX_AXES: &str = "save one array [z, y, x] of labels";
const FIX_CHANNELS: &str = "save one channel alone, as ImageJ's Image > Duplicate does without `hyperstack`";
const FIX_FRAMES: &str = "save one frame alone; if the frames are slices, set Slices to their number and Frames to 1 in \
     ImageJ's Image > Properties";

/// Edges of a voxel, with a remark.
#[derive(Default)]
pub(super) struct About {
    /// Along x, y, z, mm.
    pub(super) spacing_mm: Option<[f64; 3]>,
    /// Reason for a missing spacing, or what was assumed.
    pub(super) note: Option<String>,
}

/// What is known of the pages themselves.
pub(super) struct Pages {
    pub(super) counts: [usize; 3],
    /// Edges of a pixel along x and y, in the file's unit.
    pub(super) pixel: [Option<f64>; 2],
    /// TIFF's number of the unit of the resolution: 2 inch, 3 centimetre.
    pub(super) unit: u64,
    /// Pages that have a description.
    pub(super) descriptions: usize,
}

impl Pages {
    /// Reads a description.
    pub(super) fn described(&self, text: &str) -> Result<About, VolumeError> {
        if xml::tag(text, "Pixels").is_some() {
            return self.ome(text);
        }
        if text.trim_start().starts_with("{\"shape\":") {
            self.shaped(text)?;
        }
        self.lines(text)
    }

    fn lines(&self, text: &str) -> Result<About, VolumeError> {
        let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
        let count = |key: &str| value(key).and_then(|text| text.parse().ok()).unwrap_or(1_usize);
        let [images, channels, frames] = ["images", "channels", "frames"].map(count);
        one(channels, "channels", FIX_CHANNELS)?;
        one(frames, "frames", FIX_FRAMES)?;
        let is_imagej = text.starts_with("ImageJ=");
        let coefficient = |key: &str| value(key).filter(|_| is_imagej)?.parse::<f64>().ok();
        if let Some((offset, scale)) = coefficient("c0").zip(coefficient("c1")).filter(|pair| *pair != (0.0, 1.0)) {
            return Err(VolumeError::Unread {
                found: format!("a stack whose values mean {offset} + {scale} times its pixels"),
                fix: "set Function to None in ImageJ's Analyze > Calibrate, or convert the values",
            });
        }
        self.as_many(if value("images").is_some() { images } else { self.counts[2] })?;
        let Some(unit) = value("unit").filter(|unit| !unit.is_empty()) else { return Ok(self.printed()) };
        let units = [Some(unit), value("yunit").or(Some(unit)), value("zunit").or(Some(unit))];
        let mut mm = [0.0; 3];
        for (mm, unit) in mm.iter_mut().zip(units) {
            let unit = unit.unwrap_or_default();
            let Some(length) = length(unit) else {
                return Ok(no_size(format!("the file has its sizes in `{}`, which is no length", unit.escape_debug())));
            };
            *mm = length;
        }
        let [Some(x), Some(y)] = self.pixel else {
            return Ok(no_size("the file has a unit of length and no size of a pixel".to_owned()));
        };
        let said = value("spacing");
        let given = said.and_then(|text| text.parse::<f64>().ok()).map(f64::abs).filter(|z| *z > 0.0 && z.is_finite());
        let is_stack = self.counts[2] > 1;
        let z = match given {
            Some(z) => z,
            None if !is_stack => x * mm[0] / mm[2],
            None if is_imagej => 1.0,
            None => return Ok(no_size("the file has no distance of its slices".to_owned())),
        };
        let spacing = [x * mm[0], y * mm[1], z * mm[2]];
        let is_bad = said.is_some() && given.is_none();
        let note = (given.is_none() && is_stack && (is_bad || spacing[0] != spacing[2])).then(|| {
            let [x, _, z] = spacing;
            let why = match said.filter(|_| is_bad) {
                Some(said) => format!("the file has the `spacing` `{}`, which is no length", said.escape_debug()),
                None => format!("the file has no `spacing`, which ImageJ leaves out if it is 1 {unit}"),
            };
            format!("{why}: slices are {z} mm apart, pixels {x} mm")
        });
        Ok(About { spacing_mm: Some(spacing), note })
    }

    /// A resolution without a description is a printer's.
    fn printed(&self) -> About {
        match (self.pixel, self.unit) {
            ([Some(pixel), _], 2 | 3) => {
                let unit = if self.unit == 2 { "inch" } else { "cm" };
                no_size(format!(
                    "the file has {} pixels per {unit} as for a printer, and no distance of its slices",
                    1.0 / pixel
                ))
            }
            _ => About::default(),
        }
    }

    fn ome(&self, text: &str) -> Result<About, VolumeError> {
        let images = xml::tags(text, "Pixels").count();
        one(images, "images", "save one image alone")?;
        let pixels = xml::tag(text, "Pixels").unwrap_or_default();
        let count = |key: &str| xml::attribute(pixels, key).and_then(|text| text.parse().ok()).unwrap_or(1_usize);
        one(count("SizeC"), "channels", FIX_CHANNELS)?;
        one(count("SizeT"), "frames", FIX_FRAMES)?;
        self.as_many(count("SizeZ"))?;
        let place =
            |data: &str, key: &str| xml::attribute(data, key).and_then(|text| text.parse().ok()).unwrap_or(0_usize);
        if xml::tags(text, "TiffData").any(|data| place(data, "IFD") != place(data, "FirstZ")) {
            let found = "a stack whose pages are not in the order of their slices".to_owned();
            return Err(VolumeError::Unread { found, fix: super::FIX });
        }
        let along = |axis: &str| {
            let size: f64 = xml::attribute(pixels, &format!("PhysicalSize{axis}"))?.trim().parse().ok()?;
            let unit = xml::attribute(pixels, &format!("PhysicalSize{axis}Unit")).unwrap_or("µm");
            Some(size * length(unit)?)
        };
        let [x, y, z] = ["X", "Y", "Z"].map(along);
        let z = z.or(x.filter(|_| self.counts[2] == 1));
        let spacing_mm = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
        let missing = "the file's OME-XML has no PhysicalSizeX, PhysicalSizeY and PhysicalSizeZ that are lengths";
        Ok(About { spacing_mm, note: spacing_mm.is_none().then(|| missing.to_owned()) })
    }

    /// Refuses an array of tifffile that is no volume.
    fn shaped(&self, text: &str) -> Result<(), VolumeError> {
        let list = |key: &str, ends: [char; 2]| {
            let rest = text.split_once(&format!("\"{key}\":"))?.1.trim_start().strip_prefix(ends[0])?;
            rest.split(ends[1]).next()
        };
        let Some(shape) = list("shape", ['[', ']']) else { return Ok(()) };
        let shape: Vec<usize> = shape.split(',').filter_map(|length| length.trim().parse().ok()).collect();
        let axes: Vec<char> = list("axes", ['"', '"']).unwrap_or_default().chars().collect();
        let long: Vec<usize> = shape.iter().copied().filter(|length| *length > 1).collect();
        let is_other = |(axis, length): (&char, &usize)| "CTSHRAVL".contains(*axis) && *length > 1;
        let is_other = axes.len() == shape.len() && axes.iter().zip(&shape).any(is_other);
        let values = shape.iter().try_fold(1_usize, |product, length| product.checked_mul(*length));
        let words: Vec<String> = shape.iter().map(usize::to_string).collect();
        if long.len() > 3 || is_other {
            return Err(VolumeError::Unread {
                found: format!("an array of {} values along {} axes", words.join(" x "), words.len()),
                fix: FIX_AXES,
            });
        }
        // Programs that save a stack page by page describe each page.
        let [x, y, z] = self.counts;
        let is_page = long.len() <= 2 && self.descriptions == z && values == x.checked_mul(y);
        if values != super::super::voxels(self.counts) && !is_page {
            let found = format!("an array of {} values of which the pages hold a part", words.join(" x "));
            return Err(VolumeError::Unread { found, fix: super::FIX });
        }
        Ok(())
    }

    fn as_many(&self, stated: usize) -> Result<(), VolumeError> {
        let pages = self.counts[2];
        if pages == stated {
            return Ok(());
        }
        let found = match pages {
            1 => format!("a page that holds {stated} images"),
            _ => format!("a file of {pages} pages whose description has {stated} images"),
        };
        Err(VolumeError::Unread { found, fix: super::FIX })
    }
}

fn one(count: usize, name: &str, fix: &'static str) -> Result<(), VolumeError> {
    if count <= 1 { Ok(()) } else { Err(VolumeError::Unread { found: format!("a stack of {count} {name}"), fix }) }
}

fn no_size(reason: String) -> About {
    About { spacing_mm: None, note: Some(reason) }
}

/// Millimetres of a unit of length, as ImageJ and OME-XML write it.
fn length(unit: &str) -> Option<f64> {
    let unit = unit.trim().to_lowercase();
    let micro = ["\\u00b5", "\\u03bc", "&#181;", "&#xb5;", "&#956;", "&#x3bc;", "\u{b5}", "\u{3bc}"];
    let unit = micro.iter().fold(unit, |unit, micro| unit.replace(micro, "u"));
    let unit = unit.replace("metre", "meter");
    let singular = unit.strip_suffix('s').filter(|unit| unit.len() > 3).unwrap_or(&unit);
    Some(match singular {
        "m" | "meter" => 1e3,
        "dm" | "decimeter" => 100.0,
        "cm" | "centimeter" => 10.0,
        "mm" | "millimeter" => 1.0,
        "um" | "micron" | "micrometer" => 1e-3,
        "nm" | "nanometer" => 1e-6,
        "in" | "inch" | "inche" | "\"" => 25.4,
        "thou" | "mil" => 0.0254,
        "ft" | "feet" | "foot" => 304.8,
        _ => return None,
    })
}
