//! The functions of `libm` that the laws of Phalanx use, so that a law in another language can give the same bits.

macro_rules! of_one {
    ($($exported:ident = $function:ident),* $(,)?) => {
        $(#[unsafe(no_mangle)] extern "C" fn $exported(x: f64) -> f64 { libm::$function(x) })*
    };
}

of_one! {
    phalanx_sin = sin,
    phalanx_cos = cos,
    phalanx_tan = tan,
    phalanx_asin = asin,
    phalanx_acos = acos,
    phalanx_atan = atan,
    phalanx_sinh = sinh,
    phalanx_cosh = cosh,
    phalanx_tanh = tanh,
    phalanx_exp = exp,
    phalanx_log = log,
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}
