//! Texts of a DXF file: code pages (`$DWGCODEPAGE`), UTF-8, and characters written as `\U+00D6`.

use encoding_rs::{
    BIG5, EUC_KR, Encoding, GBK, IBM866, SHIFT_JIS, WINDOWS_874, WINDOWS_1250, WINDOWS_1251, WINDOWS_1252,
    WINDOWS_1253, WINDOWS_1254, WINDOWS_1255, WINDOWS_1256, WINDOWS_1257, WINDOWS_1258,
};

/// How the texts of a file are decoded.
pub(super) struct Decoder {
    page: &'static Encoding,
    /// Texts may be in UTF-8, whatever the code page says.
    utf8: bool,
}

impl Default for Decoder {
    fn default() -> Self {
        Decoder { page: WINDOWS_1252, utf8: true }
    }
}

/// The first version whose files are in UTF-8: AutoCAD 2007.
const FIRST_UTF8: &str = "AC1021";

impl Decoder {
    /// # Arguments
    /// * `version`: `$ACADVER`, as `AC1015`.
    /// * `page`: `$DWGCODEPAGE`, as `ANSI_1252`.
    ///
    /// `None`: the code page is unknown.
    pub fn new(version: &str, page: &str) -> Option<Self> {
        let page = if page.is_empty() { WINDOWS_1252 } else { named(page)? };
        // Programs write UTF-8 into older files, too. A text of one of these code pages may look like it by chance.
        let by_chance = [SHIFT_JIS, GBK, EUC_KR, BIG5].contains(&page);
        Some(Decoder { page, utf8: version >= FIRST_UTF8 || !by_chance })
    }

    pub fn text(&self, bytes: &[u8]) -> String {
        let text = match std::str::from_utf8(bytes) {
            Ok(text) if self.utf8 || bytes.is_ascii() => text.to_owned(),
            _ => self.page.decode_without_bom_handling(bytes).0.into_owned(),
        };
        if text.contains("\\U+") { unescaped(&text) } else { text }
    }
}

fn named(page: &str) -> Option<&'static Encoding> {
    let page = page.to_ascii_uppercase();
    let number = page.trim_start_matches(|c: char| !c.is_ascii_digit());
    Some(match number {
        "874" => WINDOWS_874,
        "866" => IBM866,
        "932" => SHIFT_JIS,
        "936" => GBK,
        "949" | "1361" => EUC_KR,
        "950" => BIG5,
        "1250" => WINDOWS_1250,
        "1251" => WINDOWS_1251,
        "1252" => WINDOWS_1252,
        "1253" => WINDOWS_1253,
        "1254" => WINDOWS_1254,
        "1255" => WINDOWS_1255,
        "1256" => WINDOWS_1256,
        "1257" => WINDOWS_1257,
        "1258" => WINDOWS_1258,
        _ => return Encoding::for_label(page.as_bytes()),
    })
}

/// With the characters that stand there by their number.
fn unescaped(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("\\U+") {
        out += before;
        let character = after.get(..4).and_then(|digits| u32::from_str_radix(digits, 16).ok()).and_then(char::from_u32);
        match character {
            Some(character) => {
                out.push(character);
                rest = &after[4..];
            }
            None => {
                out += "\\U+";
                rest = after;
            }
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_pages_are_decoded() {
        let decode = |version: &str, page: &str, bytes: &[u8]| Decoder::new(version, page).unwrap().text(bytes);
        assert_eq!(decode("AC1009", "ANSI_1252", b"\xd6ffnung"), "Öffnung");
        assert_eq!(decode("AC1015", "ansi_1251", b"\xd1\xeb\xee\xe9"), "Слой");
        assert_eq!(decode("AC1015", "ANSI_932", b"\x89~"), "円");
        // Valid UTF-8 by chance.
        assert_eq!(decode("AC1015", "ANSI_936", b"\xc1\xaa\xcd\xa8"), "联通");
        // UTF-8 in an old file, and in a new one with a code page.
        assert_eq!(decode("AC1015", "ANSI_1252", "Öffnung".as_bytes()), "Öffnung");
        assert_eq!(decode("AC1027", "ANSI_936", "Öffnung".as_bytes()), "Öffnung");
        assert_eq!(decode("", "", b"\\U+00D6ffnung \\U+00 \\U+\xd6"), "Öffnung \\U+00 \\U+Ö");
        assert!(Decoder::new("AC1009", "MARTIAN").is_none());
    }
}
