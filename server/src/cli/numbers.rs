//! Numbers with commas between them, for every subcommand that takes some.

/// N numbers with commas between them.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    let numbers = numbers.map_err(|e| e.to_string())?;
    numbers.try_into().map_err(|_| format!("use {N} numbers with commas between them"))
}
