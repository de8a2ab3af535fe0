//! The bytes of an SVG file as text: compressed or not, in the encoding that it names.

use super::error::SvgError;
use encoding_rs::{Encoding, UTF_8};
use std::borrow::Cow;
use std::io::Read;

/// Greatest size of a compressed file once it is not: that of a design with a million points.
const MAX_BYTES: u64 = 64 << 20;

/// The begin of a gzip file.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The text of a file.
pub(super) fn text(data: &[u8]) -> Result<String, SvgError> {
    let data = if data.starts_with(&GZIP) { Cow::Owned(unzipped(data)?) } else { Cow::Borrowed(data) };
    let encoding = match Encoding::for_bom(&data) {
        Some((encoding, _)) => encoding,
        None => declared(&data)?,
    };
    let (text, _, damaged) = encoding.decode(&data);
    if damaged {
        return Err(SvgError::Invalid { what: format!("it has bytes that are not {}", encoding.name()) });
    }
    Ok(text.into_owned())
}

fn unzipped(data: &[u8]) -> Result<Vec<u8>, SvgError> {
    let mut out = Vec::new();
    let mut reader = flate2::read::MultiGzDecoder::new(data).take(MAX_BYTES + 1);
    reader.read_to_end(&mut out).map_err(|error| SvgError::Invalid { what: format!("its compression: {error}") })?;
    if out.len() as u64 > MAX_BYTES { Err(SvgError::TooLarge { limit: MAX_BYTES }) } else { Ok(out) }
}

/// The encoding of `<?xml ... encoding="..."?>`; UTF-8 without.
fn declared(data: &[u8]) -> Result<&'static Encoding, SvgError> {
    let begin = String::from_utf8_lossy(&data[..data.len().min(200)]);
    let declaration = begin.trim_start().strip_prefix("<?xml").and_then(|rest| rest.split_once("?>"));
    let Some((_, value)) = declaration.and_then(|(declaration, _)| declaration.split_once("encoding")) else {
        return Ok(UTF_8);
    };
    let name = value.trim_start().strip_prefix('=').map_or("", str::trim_start);
    let quote = name.chars().next().filter(|c| ['"', '\''].contains(c));
    let name = quote.and_then(|quote| name[1..].split_once(quote)).map_or("", |(name, _)| name);
    // Without a byte order mark it cannot be UTF-16: these words are ASCII.
    let encoding =
        Encoding::for_label(name.as_bytes()).map(|found| if found.is_ascii_compatible() { found } else { UTF_8 });
    encoding.ok_or_else(|| SvgError::Encoding { name: name.chars().take(40).collect() })
}
