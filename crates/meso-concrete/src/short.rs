//! Numbers that arithmetic gives, as people write them.

/// A number of at most 12 digits, without those that rounding leaves: 100 times 0.57 is 57, not 56.99999999999999.
pub fn short(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn shares_in_per_cent_have_no_digits_of_rounding() {
        for tenth in 1..1000_u32 {
            let [percent, share] = ["", "e-2"].map(|power| format!("{}.{}{power}", tenth / 10, tenth % 10));
            let [percent, share]: [f64; 2] = [percent, share].map(|text| text.parse().unwrap());
            assert_eq!([short(100.0 * share), short(percent / 100.0)], [percent, share]);
        }
        assert_eq!(short(100.0 * 0.00007).to_string(), "0.007");
        assert_eq!([0.0, -2.5, 1e300, f64::INFINITY].map(short), [0.0, -2.5, 1e300, f64::INFINITY]);
        assert!(short(f64::NAN).is_nan());
    }
}
