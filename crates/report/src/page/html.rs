//! The report as one page of HTML: nothing is fetched, nothing runs.
//!
//! It is well-formed XML as well, so that any XML reader checks it.

use crate::error::Error;
use crate::page::section::{Part, Section, Table};
use crate::page::words::{capital, escaped};
use crate::report::Report;
use crate::verdict::Verdict;
use std::fmt::Write;

const STYLE: &str = "\
:root{color-scheme:light}\
body{font:16px/1.5 system-ui,sans-serif;color:#1a1a1a;background:#fff;max-width:78rem;margin:0 auto;padding:0 1rem 3rem}\
h1{font-size:1.6rem;margin:1.2rem 0 .3rem}h2{font-size:1.25rem;margin:2.2rem 0 .4rem;border-top:1px solid #ccc;padding-top:1rem}\
p{max-width:46rem}nav ul{columns:16rem;column-gap:1.5rem;padding-left:0}nav \
li{margin-left:1.2rem}li{break-inside:avoid}a{color:#005a8c}\
figure{margin:1rem 0}.charts{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,21rem),1fr));gap:.6rem}\
.charts svg{width:100%;height:auto;max-width:28rem}\
.legend span{display:inline-block;margin-right:1.1rem;white-space:nowrap;font-size:.9rem}.legend \
svg{vertical-align:middle}\
figcaption{font-size:.9rem;color:#444;max-width:46rem;margin-top:.3rem}\
.table{overflow-x:auto;background:linear-gradient(to right,#fff 40%,#fff0),linear-gradient(to left,#fff 40%,#fff0) 100% 0,\
linear-gradient(to right,#0003,#0000),linear-gradient(to left,#0003,#0000) 100% 0;background-repeat:no-repeat;\
background-size:2rem 100%,2rem 100%,.8rem 100%,.8rem 100%;background-attachment:local,local,scroll,scroll}\
table{border-collapse:collapse;margin:.6rem 0;font-size:.92rem}th,td{padding:.15rem .7rem;text-align:right;border-bottom:1px solid #ddd}\
td{white-space:nowrap}th:first-child,td:first-child,.words{text-align:left}td:first-child,td.words{white-space:normal}\
.verdict{border-left:.35rem solid #888;background:#f6f6f6;padding:.5rem .9rem;margin:.8rem 0;max-width:46rem}\
.verdict p{margin:.2rem 0}.yes{border-color:#009e73}.partly{border-color:#e69f00}.no{border-color:#d55e00}\
.surrogate{background:#fff3d6;border:1px solid #e69f00;padding:.5rem .9rem;max-width:46rem}\
@media(max-width:40rem){table{font-size:.8rem}th,td{padding:.15rem .3rem}}\
@media print{@page{margin:14mm}body{max-width:none;font-size:10pt;padding:0}h2,.verdict,.charts svg,tr{break-inside:avoid}\
h2,.legend{break-after:avoid}.charts{grid-template-columns:repeat(2,1fr)}.table{overflow:visible;background:none}table{font-size:8.5pt}\
th,td{padding:.1rem .35rem}nav{display:none}}";

/// The page up to its heading and warning, and the rest.
///
/// # Errors
/// [`Error::Plot`].
pub fn page(report: &Report) -> Result<(String, String), Error> {
    let title = escaped(&report.heading);
    let mut head = format!(
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
         <style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n"
    );
    if let Some(warning) = &report.warning {
        let _ = writeln!(head, "<p class=\"surrogate\">{}</p>", escaped(warning));
    }
    let mut out: String = report.introduction.iter().map(|words| paragraph(words)).collect();
    if !report.sections.is_empty() {
        out += &overview(report);
    }
    for section in &report.sections {
        out += &self::section(section, report)?;
    }
    Ok((head, out + "</body>\n</html>\n"))
}

/// A paragraph of text.
pub fn paragraph(words: &str) -> String {
    format!("<p>{}</p>\n", prose(words))
}

/// What is not parted from the number before it at the end of a line.
const UNITS: [&str; 7] = ["%", "s", "m/s", "rad/s", "deg", "N", "m"];

/// Text as HTML, numbers and their units on one line.
fn prose(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut out = String::new();
    for (i, word) in words.iter().enumerate() {
        let before = i.checked_sub(1).map_or("", |k| words[k]);
        let is_unit = UNITS.contains(&word.trim_end_matches(['.', ',', ';', ':', ')']));
        let tied = before.ends_with(|c: char| c.is_ascii_digit()) && is_unit || before.ends_with("Fig.");
        if i > 0 {
            out.push(if tied { '\u{a0}' } else { ' ' });
        }
        out.push_str(word);
    }
    escaped(&out)
}

/// The claims with their verdicts, and the way to each section.
fn overview(report: &Report) -> String {
    let mut table = Table::new(["What the paper claims", &format!("Of {}", report.subject)]);
    for verdict in report.verdicts() {
        table.rows.push(vec![capital(verdict.claim), verdict.finding.words().into()]);
    }
    let mut out = self::table(&table) + "<nav><ul>\n";
    for section in &report.sections {
        let _ = writeln!(out, "<li><a href=\"#{}\">{}</a></li>", section.id, escaped(section.title));
    }
    out + "</ul></nav>\n"
}

fn section(section: &Section, report: &Report) -> Result<String, Error> {
    let mut out = format!("<section id=\"{}\">\n<h2>{}</h2>\n", section.id, escaped(section.title));
    for part in &section.parts {
        out += &match part {
            Part::Words(words) => paragraph(words),
            Part::Figure(figure) => figure.html()?,
            Part::Table(found) => table(found),
            Part::Verdict(found) => verdict(found, &report.subject),
        };
    }
    Ok(out + "</section>\n")
}

/// A cell that begins with a letter and is longer than this makes its column one of words, not of numbers.
const WORD: usize = 12;

fn table(table: &Table) -> String {
    let is_words = |cell: &String| cell.len() > WORD && cell.starts_with(|c: char| c.is_alphabetic());
    let of_words = |column: usize| table.rows.iter().any(|row| row.get(column).is_some_and(is_words));
    let cells = |row: &[String], tag: &str| -> String {
        let class = |i: usize| if of_words(i) { " class=\"words\"" } else { "" };
        row.iter()
            .enumerate()
            .map(|(i, cell)| format!("<{tag}{}>{}</{tag}>", class(i), prose(cell)))
            .collect()
    };
    let rows: String = table.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td"))).collect();
    format!(
        "<div class=\"table\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        cells(&table.head, "th")
    )
}

fn verdict(verdict: &Verdict, subject: &str) -> String {
    format!(
        "<div class=\"verdict {}\">\n<p>The paper: {}</p>\n<p><strong>Of {}: {}.</strong> {}</p>\n<p>Judged by: \
            {}</p>\n</div>\n",
        verdict.finding.class(),
        prose(verdict.claim),
        escaped(subject),
        verdict.finding.words(),
        prose(&verdict.because),
        prose(&verdict.criterion)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_keeps_its_unit() {
        assert_eq!(
            prose("within 60 s, at 5 % & in Fig. 7"),
            "within 60\u{a0}s, at 5\u{a0}% &amp; in Fig.\u{a0}7"
        );
        assert_eq!(prose("6 controllers so 3 sets"), "6 controllers so 3 sets");
    }

    #[test]
    fn columns_of_words_are_set_as_words() {
        let mut table = Table::new(["speed", "cause", "gain"]);
        table.rows.push(["0.50", "M_uw +40 % (62 %)", "no bound"].map(str::to_owned).to_vec());
        let html = self::table(&table);
        assert!(html.contains("<th class=\"words\">cause</th><th>gain</th>"), "{html}");
        assert!(html.contains("<td>0.50</td><td class=\"words\">M_uw"), "{html}");
    }
}
