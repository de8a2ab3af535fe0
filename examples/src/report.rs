//! `report.html`: one file with its style and pictures inside, that opens from disk without a network.

use crate::finding::{Finding, Severity};
use crate::html::{base64, escaped};
use crate::plot::Plot;
use crate::table::Table;
use crate::viewer::{self, Model};
use std::fmt::Write;

/// A page, built from the top down. All text is escaped.
#[derive(Clone, Debug)]
pub struct Report {
    title: String,
    body: String,
}

impl Report {
    /// A page with a title and nothing else yet.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::{report::Report, table::Table};
    /// let mut table = Table::new(["", "ours", "paper"]);
    /// table.row(["layers", "128", "131"]);
    /// let mut report = Report::new("Curved layers");
    /// report.paragraph("Depth < 1 cell.").table("Bunny", &table);
    /// assert!(report.to_html().contains("Depth &lt; 1 cell."));
    /// ```
    pub fn new(title: &str) -> Self {
        Report { title: title.to_owned(), body: String::new() }
    }

    /// A heading under the title.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<h2>{}</h2>", escaped(text)))
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<p>{}</p>", escaped(text)))
    }

    /// A paragraph that stands out: a warning, a failed check.
    pub fn notice(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<p class=\"notice\" role=\"note\">{}</p>", escaped(text)))
    }

    /// A finding with its cause and advice: red if it failed, yellow if it is a warning, a plain paragraph if it is a note.
    pub fn finding(&mut self, finding: &Finding) -> &mut Self {
        let (class, word) = match finding.severity {
            Severity::Failed => ("notice failed", "Check failed: "),
            Severity::Warning => ("notice", ""),
            Severity::Note => ("noted", "Note: "),
        };
        let mut html = format!("<div class=\"{class}\" role=\"note\"><p>{}</p>", escaped(&format!("{word}{finding}")));
        for (word, text) in finding.advice() {
            let _ = write!(html, "\n<p class=\"advice\"><b>{word}</b> {}</p>", escaped(&text));
        }
        self.push(&(html + "</div>"))
    }

    /// A table; columns of figures are set flush right. An empty caption is left out.
    pub fn table(&mut self, caption: &str, table: &Table) -> &mut Self {
        let is_short = |column: usize| {
            let cells = || table.rows().iter().filter_map(|row| row.get(column));
            cells().all(|cell| cell.chars().count() <= SHORT_CELL)
        };
        let class = |column: usize| match (table.is_numeric(column), is_short(column)) {
            (true, _) => " class=\"figure\"",
            (false, true) => " class=\"short\"",
            _ => "",
        };
        let wide = if table.header().len() >= WIDE { " class=\"wide\"" } else { "" };
        let mut html = format!("<div class=\"scroll\"><table{wide}>");
        if !caption.is_empty() {
            let _ = write!(html, "<caption>{}</caption>", escaped(caption));
        }
        if table.header().iter().any(|cell| !cell.is_empty()) {
            html += "\n<thead><tr>";
            for (column, cell) in table.header().iter().enumerate() {
                let _ = write!(html, "<th scope=\"col\"{}>{}</th>", class(column), escaped(cell));
            }
            html += "</tr></thead>";
        }
        html += "\n<tbody>";
        for row in table.rows() {
            html += "\n<tr>";
            for (column, cell) in row.iter().enumerate() {
                let _ = match column {
                    0 if !table.is_numeric(0) => write!(html, "<th scope=\"row\"{}>{}</th>", class(0), escaped(cell)),
                    _ => write!(html, "<td{}>{}</td>", class(column), escaped(cell)),
                };
            }
            html += "</tr>";
        }
        self.push(&(html + "\n</tbody></table></div>"))
    }

    /// A PNG picture with a line under it, which also stands for it where it cannot be seen.
    pub fn picture(&mut self, caption: &str, png: &[u8]) -> &mut Self {
        self.pictures(&[(caption, png)])
    }

    /// Pictures side by side where there is room, else below one another.
    pub fn pictures(&mut self, pictures: &[(&str, &[u8])]) -> &mut Self {
        let mut html = String::from("<div class=\"pictures\">");
        for (caption, png) in pictures {
            let caption = escaped(caption);
            let _ = write!(
                html,
                "\n<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption></figure>",
                base64(png)
            );
        }
        self.push(&(html + "\n</div>"))
    }

    /// Pictures of the same size on top of each other, one seen at a time, chosen by a slider. The last is seen first.
    pub fn slider(&mut self, pictures: &[(&str, &[u8])]) -> &mut Self {
        let Some(((last, _), most)) = pictures.last().zip(pictures.len().checked_sub(1)) else { return self };
        let mut html = String::from("<figure class=\"slider\">");
        for (at, (caption, png)) in pictures.iter().enumerate() {
            let (caption, hidden) = (escaped(caption), if at == most { "" } else { " hidden" });
            let _ = write!(html, "\n<img{hidden} alt=\"{caption}\" src=\"data:image/png;base64,{}\">", base64(png));
        }
        let _ = write!(
            html,
            "\n<input type=\"range\" min=\"0\" max=\"{most}\" value=\"{most}\" aria-label=\"picture\" oninput=\"{}\">\n\
             <figcaption>{}</figcaption></figure>",
            escaped(CHOOSE),
            escaped(last)
        );
        self.push(&html)
    }

    /// An interactive 3D view of the build.
    pub fn viewer(&mut self, model: &Model) -> &mut Self {
        self.push(&model.to_html())
    }

    /// Two parts side by side where there is room, the first one wide; else below one another.
    pub fn beside(&mut self, first: impl FnOnce(&mut Report), second: impl FnOnce(&mut Report)) -> &mut Self {
        self.push("<div class=\"beside\"><div>");
        first(self);
        self.push("</div><div>");
        second(self);
        self.push("</div></div>")
    }

    /// A plot with its legend and a line under it.
    pub fn plot(&mut self, caption: &str, plot: &Plot) -> &mut Self {
        let (svg, legend, caption) = (plot.to_svg(), plot.legend(), escaped(caption));
        self.push(&format!("<figure class=\"plot\">\n{svg}\n<figcaption>{legend}{caption}</figcaption></figure>"))
    }

    /// What `fill` puts in is behind a line that opens it.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::report::Report;
    /// let mut report = Report::new("Jug");
    /// report.fold("All figures", |inner| _ = inner.paragraph("12 layers"));
    /// assert!(report.to_html().contains("<details><summary>All figures</summary>\n<p>12 layers</p>\n</details>"));
    /// ```
    pub fn fold(&mut self, summary: &str, fill: impl FnOnce(&mut Report)) -> &mut Self {
        self.push(&format!("<details><summary>{}</summary>", escaped(summary)));
        fill(self);
        self.push("</details>")
    }

    /// What another page has, without its title.
    pub fn append(&mut self, other: &Report) -> &mut Self {
        self.body += &other.body;
        self
    }

    /// A drawing, an `svg` element of ours, with a line under it. It is put in as it is.
    pub fn drawing(&mut self, caption: &str, svg: &str) -> &mut Self {
        self.push(&format!("<figure class=\"plot\">\n{svg}\n<figcaption>{}</figcaption></figure>", escaped(caption)))
    }

    fn push(&mut self, html: &str) -> &mut Self {
        self.body += html;
        self.body.push('\n');
        self
    }

    /// The page.
    pub fn to_html(&self) -> String {
        let title = escaped(&self.title);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{STYLE}{}</style>\n\
             </head>\n<body>\n<main>\n<h1>{title}</h1>\n{}</main>\n</body>\n</html>\n",
            if self.body.contains("class=\"viewer\"") { viewer::STYLE } else { "" },
            self.body
        )
    }
}

/// Tables with as many columns or more are set narrower, so that a page holds them.
const WIDE: usize = 8;

/// Columns whose cells are no longer than this, in characters, do not wrap: directions, names.
const SHORT_CELL: usize = 28;

/// Shows the picture that the slider stands at, and its caption.
const CHOOSE: &str = "const f = this.parentNode; f.querySelectorAll('img').forEach((img, i) => { \
                      img.hidden = i != this.value; if (!img.hidden) f.lastElementChild.textContent = img.alt; })";

const STYLE: &str = "\
:root { --ink: #1f2630; --soft: #5b6675; --line: #dfe3e8; --paper: #fbfbfa; --card: #ffffff; --accent: #0b7a75;
  --notice: #fff4d6; --notice-line: #d9a400;
  --failed: #fde4e1; --failed-line: #c62f22; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7eb; --soft: #9aa5b3; --line: #333b46; --paper: #15191e; --card: #1c2127; --accent: #4cc2b8;
    --notice: #33290c; --notice-line: #b58a12;
    --failed: #3b1815; --failed-line: #e0584b; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.6 system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif; }
main { max-width: 68rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 2rem; line-height: 1.2; letter-spacing: -0.015em; margin: 0 0 1.25rem; padding-bottom: 0.75rem;
  border-bottom: 3px solid var(--accent); overflow-wrap: anywhere; }
h2 { font-size: 1.25rem; line-height: 1.3; margin: 2.5rem 0 0.75rem; }
p { max-width: 44rem; margin: 0.75rem 0; overflow-wrap: anywhere; }
.notice { background: var(--notice); border-left: 4px solid var(--notice-line); padding: 0.6rem 1rem; border-radius: 4px; }
.failed { background: var(--failed); border-left: 8px solid var(--failed-line); }
div.notice, .noted { max-width: 44rem; margin: 0.75rem 0; }
.notice p, .noted p { margin: 0; }
.notice .advice, .noted .advice { margin: 0.2rem 0 0 1rem; font-size: 0.9rem; }
.advice b { color: var(--soft); font-weight: 600; margin-right: 0.3rem; }
.beside > div { min-width: 0; }
.beside td, .beside tbody th { overflow-wrap: anywhere; }
.beside td:not(:first-child) { padding-left: 0.4rem; padding-right: 0; }
.beside table { min-width: 0; }
@media (min-width: 72rem) { main:has(.beside) { max-width: 88rem; }
  .beside { display: grid; grid-template-columns: minmax(0, 1fr) 22rem; gap: 1.25rem; align-items: start; } }
.scroll { overflow-x: auto; width: fit-content; max-width: max(100%, calc(50vw + 50% - 2rem)); margin: 1.25rem 0; }
.beside .scroll, details .scroll { max-width: 100%; }
table { border-collapse: collapse; font-size: 0.94rem; min-width: min(24rem, 100%); }
caption { text-align: left; color: var(--soft); padding-bottom: 0.4rem; }
th, td { padding: 0.38rem 1.1rem 0.38rem 0; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: baseline; }
th:not(:first-child), td:not(:first-child) { padding-left: 1.1rem; }
thead th { color: var(--soft); font-weight: 600; border-bottom: 2px solid var(--line); vertical-align: bottom; }
tbody th { font-weight: 400; }
tbody tr:last-child > * { border-bottom-color: transparent; }
.figure { text-align: right; font-variant-numeric: tabular-nums; }
td.figure, tbody .short { white-space: nowrap; }
.wide { font-size: 0.82rem; }
.wide th, .wide th:not(:first-child), .wide td, .wide td:not(:first-child) { padding-left: 0.35rem; padding-right: 0.35rem; }
.wide th, .wide tbody .short { white-space: normal; }
.beside .short { white-space: normal; }
@media (max-width: 60rem) { tbody .short { white-space: normal; } }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1.25rem;
  margin: 1.25rem 0; align-items: start; }
figure { margin: 0; background: var(--card); border: 1px solid var(--line); border-radius: 8px; overflow: hidden; }
.slider { max-width: 44rem; margin: 1.25rem 0; }
.slider input { display: block; width: calc(100% - 1.8rem); margin: 0.7rem 0.9rem; accent-color: var(--accent); }
figure img:not([hidden]) { display: block; width: 100%; height: auto; background: #ffffff; }
figcaption { padding: 0.6rem 0.9rem; color: var(--soft); font-size: 0.9rem; border-top: 1px solid var(--line); }
.plot { margin: 1.25rem 0; }
.plot svg { display: block; width: 100%; height: auto; font-size: 12px; }
.plot text { fill: var(--soft); }
.plot .x { text-anchor: middle; }
.plot .y { text-anchor: end; }
.plot .grid { stroke: var(--line); fill: none; }
.plot .line { fill: none; stroke-width: 1.4; stroke-linejoin: round; }
.key { white-space: nowrap; margin-right: 1rem; }
.key i { display: inline-block; width: 1.1em; height: 0.3em; margin-right: 0.4em; vertical-align: middle; }
details { margin: 1.5rem 0; }
summary { cursor: pointer; font-weight: 600; }
@media print { .scroll { overflow: visible; max-width: none; } table { font-size: 0.7rem; } body { background: none; } figure { break-inside: avoid; } }
";
