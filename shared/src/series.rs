//! Exponential, logarithm and square root for tables made at compile time, where neither `std`
//! nor `libm` can be called. Only + - * / are used, so a table is the same on every machine.

/// The square root of `x` >= 0, to the last bit or two.
pub(crate) const fn sqrt(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    // Newton's iteration from above falls until rounding stops it.
    let mut root = if x > 1.0 { x } else { 1.0 };
    loop {
        let next = 0.5 * (root + x / root);
        if next >= root {
            return root;
        }
        root = next;
    }
}

/// e^x for |x| up to some hundreds, to about 1e-14 of its value.
pub(crate) const fn exp(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 / exp(-x);
    }
    // e^x = (e^(x / 2^n))^(2^n), with an argument small enough for twelve terms.
    let (mut small, mut halvings) = (x, 0);
    while small > 0.125 {
        small *= 0.5;
        halvings += 1;
    }
    let (mut sum, mut term, mut n) = (1.0, 1.0, 1);
    while n <= 12 {
        term *= small / n as f64;
        sum += term;
        n += 1;
    }
    while halvings > 0 {
        sum *= sum;
        halvings -= 1;
    }
    sum
}

/// The natural logarithm of `x` > 0, to about 1e-13. (The check of the parameters keeps all
/// arguments above zero; -710 stands for the logarithm of anything else.)
pub(crate) const fn ln(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return -710.0;
    }
    // ln x = 2^n ln x^(1 / 2^n), with an argument near one; then 2 artanh((x - 1) / (x + 1)).
    let (mut near, mut factor) = (x, 2.0);
    while near < 0.8 || near > 1.25 {
        near = sqrt(near);
        factor *= 2.0;
    }
    let ratio = (near - 1.0) / (near + 1.0);
    let (mut sum, mut power, mut n) = (0.0, ratio, 1);
    while n <= 21 {
        sum += power / n as f64;
        power *= ratio * ratio;
        n += 2;
    }
    factor * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_agree_with_the_standard_library() {
        for k in -400..400 {
            let x = f64::from(k) * 0.0371;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-13, "exp {x}");
            let positive = x.exp();
            assert!((ln(positive) - x).abs() < 1e-12, "ln {positive}");
            assert!(
                (sqrt(positive) / positive.sqrt() - 1.0).abs() < 1e-15,
                "sqrt {positive}"
            );
        }
    }
}
