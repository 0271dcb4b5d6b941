//! Report as a self-contained HTML page with an optional script.
//!
//! The page is also well-formed XML, so that any XML reader can check it.

use crate::page::{Boxed, FONT, Part, STYLE as CHARTS, Section, Table, escaped};
use crate::report::Report;
use std::fmt::Write;

/// Style of the page; the style of charts is in the figures.
const STYLE: &str = include_str!("page.css");
/// Optional script: shows values under the pointer and toggles lines.
const SCRIPT: &str = include_str!("hover.js");

/// Returns the page in two parts, before and after the position of the origin below heading and warning.
pub fn page(report: &Report) -> (String, String) {
    let title = escaped(&report.heading);
    let mut head = format!(
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
         <style>{STYLE}body,svg{{font-family:{FONT}}}\n{CHARTS}</style></head>\n<body>\n<header>\n<h1>{title}</h1>\n"
    );
    if let Some(warning) = report.warning() {
        let _ = writeln!(head, "<p class=\"surrogate\">{}</p>", escaped(&warning));
    }
    let mut out: String = report.introduction.iter().map(|words| paragraph(words)).collect();
    out += &overview(report);
    report.sections.iter().for_each(|section| out += &self::section(section));
    (head, format!("{out}</main>\n<script>/*<![CDATA[*/\n{SCRIPT}/*]]>*/</script>\n</body>\n</html>\n"))
}

/// Returns a paragraph of text.
pub fn paragraph(words: &str) -> String {
    format!("<p>{}</p>\n", prose(words))
}

/// Units that stay on the same line as their number.
const UNITS: [&str; 7] = ["%", "s", "m/s", "rad/s", "deg", "N", "m"];

/// Converts text to HTML, with units on the same line as their number.
fn prose(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut out = String::new();
    for (i, word) in words.iter().enumerate() {
        let before = i.checked_sub(1).map_or("", |k| words[k]);
        let is_unit = UNITS.contains(&word.trim_end_matches(['.', ',', ';', ':', ')']));
        let tied = before.ends_with(|c: char| c.is_ascii_digit()) && is_unit
            || before.ends_with("Fig.")
            || ["=", "<", ">"].contains(&before)
            || *word == "=";
        if i > 0 {
            out.push(if tied { '\u{a0}' } else { ' ' });
        }
        out.push_str(word);
    }
    // Code is between backticks.
    let typed = |(i, part): (usize, &str)| match i % 2 {
        0 => escaped(part),
        _ => format!("<code>{}</code>", escaped(part)),
    };
    out.split('`').enumerate().map(typed).collect()
}

/// Returns links to the sections.
fn overview(report: &Report) -> String {
    let mut out = "</header>\n<nav><ul>\n".to_owned();
    for section in &report.sections {
        let _ = writeln!(out, "<li><a href=\"#{}\">{}</a></li>", section.id, escaped(&section.title));
    }
    out + "</ul></nav>\n<main>\n"
}

fn section(section: &Section) -> String {
    let mut out = format!("<section id=\"{}\">\n<h2>{}</h2>\n", section.id, escaped(&section.title));
    for part in &section.parts {
        out += &match part {
            Part::Text(words) => paragraph(words),
            Part::Figure(figure) => figure.html(),
            Part::Table(found) => table(found),
            Part::Diagram(diagram) => diagram.html(),
            Part::Boxed(found) => boxed(found),
        };
    }
    out + "</section>\n"
}

/// Length above which a cell that starts with a letter marks its column as text instead of numbers.
const WORD: usize = 12;

fn table(table: &Table) -> String {
    let is_words = |cell: &String| cell.len() > WORD && cell.starts_with(|c: char| c.is_alphabetic());
    let of_words = |column: usize| table.rows.iter().any(|row| row.get(column).is_some_and(is_words));
    let cells = |row: &[String], tag: &str| -> String {
        let class = |i: usize, cell: &str| match cell {
            "met" => " class=\"met\"",
            _ if cell.ends_with("MISSED") => " class=\"missed\"",
            _ if of_words(i) => " class=\"words\"",
            _ => "",
        };
        row.iter()
            .enumerate()
            .map(|(i, cell)| format!("<{tag}{}>{}</{tag}>", class(i, cell), prose(cell)))
            .collect()
    };
    let rows: String = table.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td"))).collect();
    format!(
        "<div class=\"table\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        cells(&table.head, "th")
    )
}

fn boxed(boxed: &Boxed) -> String {
    let paragraph = |(bold, rest): &(String, String)| match bold.as_str() {
        "" => self::paragraph(rest),
        _ => format!("<p><strong>{}</strong> {}</p>\n", prose(bold), prose(rest)),
    };
    let paragraphs: String = boxed.paragraphs.iter().map(paragraph).collect();
    format!("<div class=\"boxed {}\">\n{paragraphs}</div>\n", boxed.mark)
}

/// Returns the origin of the page: the style for each printed page, and the paragraph below the heading.
pub fn origin(words: &str) -> (String, String) {
    // A CSS string in HTML.
    let quoted: String = words.chars().filter(|c| !c.is_control() && !"\"\\<&".contains(*c)).collect();
    let style = format!("<style>@page{{@bottom-left{{content:\"{quoted}\"}}}}</style>\n");
    (style, format!("<p class=\"origin\">{}</p>\n", escaped(words)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stay_with_numbers() {
        assert_eq!(prose("60 s, 5 % & Fig. 7"), "60\u{a0}s, 5\u{a0}% &amp; Fig.\u{a0}7");
        assert_eq!(prose("6 controllers so 3 sets"), "6 controllers so 3 sets");
        assert_eq!(prose("run `a <b>`"), "run <code>a &lt;b&gt;</code>");
        assert_eq!(prose("< 10 %"), "&lt;\u{a0}10\u{a0}%");
        assert_eq!(prose("w_b = 0.23"), "w_b\u{a0}=\u{a0}0.23");
    }

    #[test]
    fn box_has_mark_and_bold_text() {
        let paragraphs =
            vec![("Of it: yes.".into(), "5 of 6 < 7.".into()), (String::new(), "By `rule`.".into())];
        insta::assert_snapshot!(boxed(&Boxed { mark: "yes", paragraphs }));
    }

    #[test]
    fn columns_of_text_are_set_as_text() {
        let mut table = Table::new(["speed", "cause", "gain"]);
        table.rows.push(["0.50", "M_uw +40 % (62 %)", "no bound"].map(str::to_owned).to_vec());
        let html = self::table(&table);
        assert!(html.contains("<th class=\"words\">cause</th><th>gain</th>"), "{html}");
        assert!(html.contains("<td>0.50</td><td class=\"words\">M_uw"), "{html}");
    }
}
