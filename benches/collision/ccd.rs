//! libccd (Debian libccd2), loaded at run time where it is installed.
#![allow(unsafe_code, reason = "calls into a C library")]

use meso_collision::math::Vec3;
use std::cell::Cell;
use std::ffi::{c_char, c_int, c_ulong, c_void};

type Vector = [f64; 3];
type Support = extern "C" fn(*const c_void, *const Vector, *mut Vector);
type Centre = extern "C" fn(*const c_void, *mut Vector);
type Intersect = unsafe extern "C" fn(*const c_void, *const c_void, *const Parameters) -> c_int;

/// `ccd_t` of ccd.h, double precision.
#[repr(C)]
struct Parameters {
    first_direction: extern "C" fn(*const c_void, *const c_void, *mut Vector),
    support1: Support,
    support2: Support,
    centre1: Centre,
    centre2: Centre,
    max_iterations: c_ulong,
    epa_tolerance: f64,
    mpr_tolerance: f64,
    distance_tolerance: f64,
}

/// The points of a body, what is added to them, and a point inside.
struct Placed<'a> {
    points: &'a [Vec3],
    at: Vec3,
    centre: Vec3,
    /// Supports asked for.
    calls: Cell<u32>,
}

/// Supports per query after which libccd is taken to cycle: its MPR heeds no limit of its own.
const LIMIT: u32 = 2000;

/// The library's two boolean tests.
pub struct Ccd {
    mpr: Intersect,
    gjk: Intersect,
    parameters: Parameters,
}

impl Ccd {
    /// The installed library, or the reason why there is none.
    pub fn load() -> Result<Self, String> {
        unsafe extern "C" {
            fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
            fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
        }
        const NOW: c_int = 2;
        // SAFETY: the names are C strings; the symbols have the types of ccd.h where the library is libccd 2.
        unsafe {
            let library = dlopen(c"libccd.so.2".as_ptr(), NOW);
            if library.is_null() {
                return Err("libccd.so.2 is not installed (Debian: apt install libccd2); skipped".into());
            }
            let symbol = |name: &std::ffi::CStr| {
                let address = dlsym(library, name.as_ptr());
                if address.is_null() { Err(format!("libccd lacks {name:?}; skipped")) } else { Ok(address) }
            };
            let (mpr, gjk) = (symbol(c"ccdMPRIntersect")?, symbol(c"ccdGJKIntersect")?);
            let [mpr, gjk] = [mpr, gjk].map(|f| std::mem::transmute::<*mut c_void, Intersect>(f));
            Ok(Self { mpr, gjk, parameters: parameters() })
        }
    }

    /// `ccdMPRIntersect` of A and B displaced by `x`.
    pub fn mpr(&self, a: &[Vec3], b: &[Vec3], x: &Vec3) -> bool {
        self.ask(self.mpr, a, b, x)
    }

    /// `ccdGJKIntersect`.
    pub fn gjk(&self, a: &[Vec3], b: &[Vec3], x: &Vec3) -> bool {
        self.ask(self.gjk, a, b, x)
    }

    /// `ccdMPRIntersect` of bodies where they are, with a point inside of each; `None` where it would not end.
    pub fn mpr_of(&self, a: &[Vec3], b: &[Vec3], centres: &[Vec3; 2]) -> Option<bool> {
        self.ask_placed(self.mpr, a, b, &Vec3::zeros(), centres)
    }

    /// `ccdGJKIntersect` of the same.
    pub fn gjk_of(&self, a: &[Vec3], b: &[Vec3], centres: &[Vec3; 2]) -> Option<bool> {
        self.ask_placed(self.gjk, a, b, &Vec3::zeros(), centres)
    }

    fn ask(&self, test: Intersect, a: &[Vec3], b: &[Vec3], x: &Vec3) -> bool {
        self.ask_placed(test, a, b, x, &[Vec3::zeros(), *x]).unwrap_or(false)
    }

    fn ask_placed(&self, test: Intersect, a: &[Vec3], b: &[Vec3], x: &Vec3, centres: &[Vec3; 2]) -> Option<bool> {
        let a = Placed { points: a, at: Vec3::zeros(), centre: centres[0], calls: Cell::new(0) };
        let b = Placed { points: b, at: *x, centre: centres[1], calls: Cell::new(0) };
        // SAFETY: the callbacks get these two back, and they outlive the call.
        let answer = unsafe { test((&raw const a).cast(), (&raw const b).cast(), &raw const self.parameters) != 0 };
        (a.calls.get() <= LIMIT).then_some(answer)
    }
}

fn parameters() -> Parameters {
    Parameters {
        first_direction,
        support1: support,
        support2: support,
        centre1: centre,
        centre2: centre,
        // The default never ends on some flat pairs; nobody needs so many.
        max_iterations: 10_000,
        epa_tolerance: 1e-4,
        mpr_tolerance: 1e-4,
        distance_tolerance: 1e-6,
    }
}

extern "C" fn first_direction(a: *const c_void, b: *const c_void, out: *mut Vector) {
    // SAFETY: libccd passes the objects it was given, and a vector to fill.
    unsafe {
        let (a, b) = (&*a.cast::<Placed<'_>>(), &*b.cast::<Placed<'_>>());
        *out = (b.centre - a.centre).into();
    }
}

extern "C" fn centre(body: *const c_void, out: *mut Vector) {
    // SAFETY: as above.
    unsafe { *out = (*body.cast::<Placed<'_>>()).centre.into() }
}

extern "C" fn support(body: *const c_void, direction: *const Vector, out: *mut Vector) {
    // SAFETY: as above.
    unsafe {
        let (body, direction) = (&*body.cast::<Placed<'_>>(), Vec3::from(*direction));
        body.calls.set(body.calls.get() + 1);
        if body.calls.get() > LIMIT {
            // The same point of both bodies: the difference is 0, at which libccd gives up.
            *out = [0.0; 3];
            return;
        }
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, p) in body.points.iter().enumerate() {
            let height = p.dot(&direction);
            if height > best.0 {
                best = (height, i);
            }
        }
        *out = (body.points[best.1] + body.at).into();
    }
}
