//! The report: all figures and the numbers on one page of HTML, with nothing outside it.

use std::fmt::Write as _;

use super::figure::Figure;
use super::shape::number;
use rover_simulator::experiment::{Estimate, ExamResult, Trial};

/// Something worth knowing, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fact {
    pub name: String,
    pub value: String,
}

/// What there is to say of sessions, which consist of trials or what `unit` calls them, and of the
/// trials that the figures show.
pub(super) fn facts(
    sessions: &[&[Trial]],
    shown: &[Trial],
    unit: &str,
    which: &str,
    patterns: usize,
    follow_direction: bool,
) -> Vec<Fact> {
    let mut facts = Vec::new();
    let mut add = |name: String, value: String| facts.push(Fact { name, value });
    let actions = |trials: &[Trial]| trials.iter().map(|t| u64::from(t.steps)).sum::<u64>();
    let Some(first) = sessions.first() else {
        return facts;
    };
    add(format!("{unit}s"), first.len().to_string());
    add("actions".into(), actions(first).to_string());
    add("patterns known at the end".into(), patterns.to_string());
    if sessions.len() > 1 {
        add(
            "sessions in the learning curves".into(),
            sessions.len().to_string(),
        );
    }
    if let (Some(trial), false) = (first.first(), follow_direction)
        && let Some(directedness) = trial.directedness
    {
        add(
            "directedness of the first trial".into(),
            number(directedness, 2),
        );
    }
    let result = ExamResult::new(shown, !follow_direction);
    let measures: [(&str, Option<Estimate>, usize); 7] = [
        ("target reached", result.reached, 3),
        ("reached without a collision", result.clean, 3),
        (
            "directedness",
            result.directedness.filter(|_| !follow_direction),
            2,
        ),
        ("way / straight distance", result.path_ratio, 2),
        ("actions", result.steps, 1),
        ("share of blocked moves", result.blocked, 4),
        (
            "angle to the direction, nothing in sight (degrees)",
            result.free_angle_deg,
            1,
        ),
    ];
    for (name, estimate, decimals) in measures {
        if let Some(e) = estimate {
            // None of these can be negative, though the interval of a mean knows nothing of that.
            let low = e.low.max(0.0);
            let [value, low, high] = [e.value, low, e.high].map(|v| number(v, decimals));
            let interval = if e.low.is_finite() {
                format!(" (95 %: {low} to {high})")
            } else {
                String::new()
            };
            add(format!("{which}: {name}"), format!("{value}{interval}"));
        }
    }
    facts
}

const STYLE: &str = "\
body{margin:0 auto;max-width:70rem;padding:1.5rem;color:#222;background:#fff;\
font:16px/1.5 Helvetica,Arial,sans-serif}\
h1{font-size:1.6rem;line-height:1.2;margin:0 0 .5rem}\
h2{font-size:1.15rem;margin:2.5rem 0 .5rem}\
p{max-width:46rem}\
figure{margin:0;overflow-x:auto}\
figure svg{display:block;max-width:100%;min-width:44rem;height:auto;border:1px solid #e3e3e3}\
figcaption{max-width:46rem;margin-top:.5rem;color:#444}\
nav ul{padding-left:1.2rem;margin:.5rem 0}\
table{border-collapse:collapse;margin:1rem 0}\
th,td{text-align:left;padding:.2rem 1.2rem .2rem 0;border-bottom:1px solid #e3e3e3;\
font-weight:normal;vertical-align:top}\
td{font-variant-numeric:tabular-nums}\
a{color:#0072b2}\
footer{margin-top:3rem;color:#595959;font-size:.9rem}\
@media print{nav{display:none}section{break-inside:avoid}body{max-width:none;padding:0}figure svg{min-width:0}}";

/// The page.
pub(super) fn page(about: &str, facts: &[Fact], figures: &[Figure]) -> String {
    let mut page =
        String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n");
    page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n";
    // Nothing is loaded, whatever a viewer would allow.
    page += "<meta http-equiv=\"Content-Security-Policy\" \
             content=\"default-src 'none'; style-src 'unsafe-inline'\"/>\n";
    let _ = writeln!(page, "<title>Turing Rover: {}</title>", escaped(about));
    let _ = writeln!(page, "<style>{STYLE}</style>\n</head>\n<body>\n<main>");
    page += "<h1>Turing Rover: what was perceived, learned and done</h1>\n";
    let _ = writeln!(page, "<p>{}.</p>", escaped(about));
    page += "<table>\n<tbody>\n";
    for Fact { name, value } in facts {
        let (name, value) = (escaped(name), escaped(value));
        let _ = writeln!(
            page,
            "<tr><th scope=\"row\">{name}</th><td>{value}</td></tr>"
        );
    }
    page += "</tbody>\n</table>\n<nav aria-label=\"Figures\">\n<ul>\n";
    for figure in figures {
        let (id, title) = (id(figure), title(figure));
        let _ = writeln!(
            page,
            "<li><a href=\"#{id}\">{title}</a>{}</li>",
            of_paper(figure)
        );
    }
    page += "</ul>\n</nav>\n";
    for figure in figures {
        let _ = write!(
            page,
            "<section id=\"{id}\">\n<h2>{title}</h2>\n<figure>\n{svg}\
             <figcaption>{caption}{paper}</figcaption>\n</figure>\n</section>\n",
            id = id(figure),
            title = title(figure),
            svg = inlined(figure),
            caption = escaped(&figure.caption),
            paper = of_paper(figure),
        );
    }
    let _ = writeln!(
        page,
        "</main>\n<footer>Figures of the paper: Arena, Fortuna, Lombardo, Patan\u{e8}, \
         <i>Perception for action: dynamic spatiotemporal patterns applied on a roving robot</i>, \
         2008. Drawn by rover {} from the data named above.</footer>\n</body>\n</html>",
        env!("CARGO_PKG_VERSION")
    );
    page
}

fn of_paper(figure: &Figure) -> String {
    match figure.paper {
        "" => String::new(),
        paper => format!(" (the paper's {})", escaped(paper)),
    }
}

fn id(figure: &Figure) -> &str {
    figure.name.trim_end_matches(".svg")
}

/// The figure's title, escaped as it stands in the figure.
fn title(figure: &Figure) -> String {
    let rest = figure
        .svg
        .split_once("<title>")
        .map_or("", |(_, rest)| rest);
    let title = rest
        .split_once("</title>")
        .map_or(figure.name, |(title, _)| title);
    title.trim().to_owned()
}

/// The drawing, with title and description bound to it for screen readers.
fn inlined(figure: &Figure) -> String {
    let id = id(figure);
    let svg = figure.svg.replacen(
        "<svg ",
        &format!("<svg aria-labelledby=\"{id}-title {id}-description\" "),
        1,
    );
    let svg = without_title(&svg).unwrap_or(svg);
    let svg = svg.replacen("<title>", &format!("<title id=\"{id}-title\">"), 1);
    svg.replacen("<desc>", &format!("<desc id=\"{id}-description\">"), 1)
}

/// The drawing without the line that holds its title, which the page has above it.
fn without_title(svg: &str) -> Option<String> {
    const TITLE: f64 = 32.0;
    let (_, rest) = svg.split_once(" viewBox=\"0 0 ")?;
    let (size, _) = rest.split_once('"')?;
    let (width, height) = size.split_once(' ')?;
    let shorter = height.parse::<f64>().ok()? - TITLE;
    let svg = svg.replacen(
        &format!(" viewBox=\"0 0 {size}\""),
        &format!(" viewBox=\"0 {TITLE} {width} {shorter}\""),
        1,
    );
    let tall = format!(" height=\"{height}\"");
    Some(svg.replacen(&tall, &format!(" height=\"{shorter}\""), 1))
}

/// Text as HTML and XML write it.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_outside_cannot_become_markup() {
        let page = page("Log <script>&\"", &[], &[]);
        assert!(page.contains("Log &lt;script&gt;&amp;&quot;"));
        assert!(!page.contains("<script"));
    }
}
