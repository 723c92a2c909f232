//! Numbers as people read them.

/// A number as JSON has it: none where it is not finite.
pub fn json(x: f64) -> serde_json::Value {
    x.is_finite().then_some(x).into()
}

/// A number as CSV has it: every digit, so that it is read back to the last bit.
pub fn csv(x: f64) -> String {
    format!("{x:e}")
}

/// A small or large number with two digits: `2.1e-12`; what is not finite as `–`.
pub fn rough(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if x.is_finite() {
        format!("{x:.1e}")
    } else {
        "–".into()
    }
}

/// A number of everyday size with three digits or so: `0.0123`, `1.23`, `12.3`, `1 230`.
pub fn plain(x: f64) -> String {
    let size = x.abs();
    if !x.is_finite() {
        "–".into()
    } else if x == 0.0 {
        "0".into()
    } else if size < 1e-3 {
        rough(x)
    } else if size < 999.5 {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        grouped(x)
    }
}

/// A whole number with its thousands apart: `12 300`.
pub fn grouped(x: f64) -> String {
    let digits = format!("{:.0}", x.abs());
    let mut text = String::from(if x < 0.0 { "−" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A power of ten as it stands on an axis: `10⁻⁹`.
pub fn power_of_ten(exponent: i32) -> String {
    let raised = |digit| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        digit => char::from_u32(u32::from('⁰') + u32::from(digit) - u32::from('0')).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_long_as_they_need_to_be() {
        let shown = [0.0, 2.13e-12, 0.012_34, 1.234, 12.34, 123.4, 1234.0, 1_234_567.0].map(plain);
        let wanted =
            ["0", "2.1e-12", "0.0123", "1.23", "12.3", "123", "1\u{202f}234", "1\u{202f}234\u{202f}567"];
        assert_eq!(shown, wanted);
        assert_eq!([-12, 0, 3].map(power_of_ten), ["10⁻¹²", "10⁰", "10³"]);
        assert_eq!(rough(f64::NAN), "–");
    }

    #[test]
    fn csv_keeps_every_bit() {
        for x in [0.1, 1.0 / 3.0, 6.626e-34, f64::MIN_POSITIVE, 1e300] {
            assert_eq!(csv(x).parse::<f64>().unwrap(), x);
        }
    }
}
