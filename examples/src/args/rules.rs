//! Which values options may have, for clap.

pub(super) fn count(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|&n| n > 0).ok_or_else(|| "must be an integer of at least 1".to_owned())
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number".to_owned())
}

/// A finite number above zero, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn above_zero(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("must be above 0 and finite".to_owned()) }
}

/// A number from 0 on, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn from_zero(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value.is_finite() && value >= 0.0 { Ok(value) } else { Err("must be 0 or more, and finite".to_owned()) }
}

/// A share from 0 to 1, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn share(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 1".to_owned()) }
}

/// A number above zero, or `inf` for no limit, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn limit(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err("must be above 0, or inf for no limit".to_owned()) }
}

/// A temperature, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn celsius(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=600.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 600".to_owned()) }
}

pub(super) fn eps(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=16.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 16".to_owned()) }
}
