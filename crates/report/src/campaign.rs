//! Page of a campaign: outcomes of the flights, the distribution of each figure, and its correlations.

use crate::page::{Axis, Chart, Curve, Figure, Key, Part, Section, Table, percent};
use crate::rendered::Rendered;
use crate::report::Report;
use crate::simulate::heading;
use squid_base::numbers::{above, decimals};
use squid_campaign::bound::Gains;
use squid_campaign::flight::Row;
use squid_campaign::plan::{Plan, Points};
use squid_campaign::summary::{QUANTILES, Share, Spread};

/// Number of steps of a plotted distribution.
const STEPS: usize = 200;

/// Number of flights plotted as points: more would hide one another.
const DRAWN: usize = 500;

/// Smallest rank correlation that is shown.
pub const STRONG: f64 = 0.2;

/// Returns the page of a campaign, from its rows, their statistics, and the gains of its first vehicles.
pub fn page(plan: &Plan<'_>, rows: &[Row], shares: &[Share], spreads: &[Spread], gains: &[Gains]) -> String {
    let inputs = plan.first().inputs;
    let steered: Vec<&str> = plan.axes.iter().map(|axis| axis.steered_signal().name).collect();
    let unproved = plan.axes.iter().filter_map(|axis| axis.stored.unproved(axis.inputs)).collect();
    let flown = if steered.len() > 1 { ", in six degrees of freedom" } else { "" };
    let where_ = match plan.identity.points {
        Points::Uniform => "from the whole of",
        Points::Sobol => "from a Sobol sequence over",
        Points::Corners => "at corners of",
    };
    let at_sea = match &plan.identity.sea {
        Some(_) => "each in a random sea",
        None => "still water",
    };
    let introduction = vec![
        format!(
            "{} flights, seed {}: vehicles {where_} the declared uncertainty ({} numbers), performing the default \
             manoeuvre between two random speeds of the range, with the {} step up or down, {at_sea}{}{flown}.",
            rows.len(),
            plan.identity.seed,
            plan.uncertain.len(),
            steered.join(" and the "),
            plan.identity.starts.text()
        ),
        "Flights are samples and prove nothing about other vehicles. `squid replay` repeats one and plots it."
            .to_owned(),
    ];
    let mut sections = vec![ended(shares), spread(plan, rows, spreads), pushed(plan, rows, spreads)];
    sections.extend(gains.first().map(|first| guaranteed(first.drawn.len() + first.outside, gains)));
    let report = Report {
        heading: format!("{}: {} flights", heading(inputs), rows.len()),
        introduction,
        sections,
        ..Report::without_sections(inputs, unproved)
    };
    Rendered::of(&report).page(&[])
}

fn guaranteed(vehicles: usize, gains: &[Gains]) -> Section {
    let text = format!(
        "Gain of the loop from w to z, which gamma bounds for a model without errors: for the linear model at a \
         constant speed and the controller frozen at this speed, in continuous time. Sampled: the vehicles of the \
         first {vehicles} flights, each in its own trim. Guaranteed: for all constant values of the uncertain \
         numbers of the model, by mu with a performance block, at all frequencies; computed, not proved in exact \
         arithmetic. In the model the incidence is an independent number, to first order. Sampled gains cannot \
         exceed the guaranteed ones; vehicles that were not sampled may lie between the two. The bound does not \
         cover limits of actuators, the sea, or a changing speed."
    );
    let head = [
        "speed",
        "median of the samples",
        "largest",
        "in flight",
        "guaranteed for the model",
        "without gain",
    ];
    let mut table = Table::new(head);
    let several = gains.iter().any(|at| Some(at.axis) != gains.first().map(|first| first.axis));
    for at in gains {
        let of_axis = if several { format!("{}, ", at.axis) } else { String::new() };
        let mut sorted: Vec<f64> = at.drawn.iter().map(|(_, gain)| *gain).collect();
        sorted.sort_by(f64::total_cmp);
        let shown = |gain: f64| if gain.is_finite() { decimals(gain, 4) } else { "unstable".to_owned() };
        table.rows.push(vec![
            format!("{of_axis}{} m/s", decimals(at.speed, 2)),
            sorted.get(sorted.len() / 2).map_or_else(String::new, |gain| shown(*gain)),
            at.largest().map_or_else(String::new, |(_, gain)| shown(gain)),
            at.largest().map_or_else(String::new, |(flight, _)| flight.to_string()),
            at.guaranteed.map_or_else(|| "no bound".to_owned(), |bound| format!("below {}", above(bound))),
            at.outside.to_string(),
        ]);
    }
    let without = "Without gain: vehicles without trim at this speed, or with a trim outside the range found at the \
                   corners of the declared uncertainty, which the bound does not cover.";
    let parts = vec![Part::Text(text), Part::Table(table), Part::Text(without.into())];
    Section::new("guaranteed", "The largest sampled gain and the guaranteed gain", parts)
}

fn ended(shares: &[Share]) -> Section {
    let mut table = Table::new(["outcome", "flights", "share", "95 % interval"]);
    for Share { outcome, flights, share, interval: [low, high] } in shares {
        let interval = format!("{} to {}", percent(*low, 2), percent(*high, 2));
        table.rows.push(vec![(*outcome).to_owned(), flights.to_string(), percent(*share, 2), interval]);
    }
    let text = "The interval is that of Wilson (1927) for the probability of the outcome, with a confidence of 95 %.";
    Section::new("outcomes", "Outcomes", vec![Part::Table(table), Part::Text(text.into())])
}

/// Returns how to display a figure: its name, its unit, and the factor to that unit.
fn shown(figure: &str, unit: &'static str) -> (String, &'static str, f64) {
    let (unit, factor) = match unit {
        "1" => ("%", 100.0),
        "rad" => ("deg", 1f64.to_degrees()),
        other => (other, 1.0),
    };
    (figure.replace('_', " "), unit, factor)
}

/// Returns the figures that vary between flights.
fn varied(spreads: &[Spread]) -> impl Iterator<Item = &Spread> {
    spreads.iter().filter(|spread| spread.quantiles[0] != spread.largest)
}

/// Returns the finite values of a figure, each with its row.
fn known<'r>(plan: &Plan<'_>, rows: &'r [Row], figure: &str) -> Vec<(f64, &'r Row)> {
    let index = plan.figures().iter().position(|(name, _)| name == figure);
    let value = |row: &'r Row| index.map(|index| (row.figures[index], row));
    rows.iter().filter_map(value).filter(|(value, _)| value.is_finite()).collect()
}

fn spread(plan: &Plan<'_>, rows: &[Row], spreads: &[Spread]) -> Section {
    let mut table = Table::new(["figure", "median", "95 %", "99 %", "largest", "in flight"]);
    let mut charts = Vec::new();
    for Spread { figure, unit, quantiles, largest, flight, .. } in spreads {
        let (name, unit, factor) = shown(figure, unit);
        let cell = |v: &f64| {
            if v.is_infinite() { "never".to_owned() } else { format!("{} {unit}", decimals(factor * v, 3)) }
        };
        let cells = quantiles.iter().chain([largest]).map(cell);
        table.rows.push([name].into_iter().chain(cells).chain([flight.to_string()]).collect());
    }
    for Spread { figure, unit, .. } in varied(spreads) {
        let (name, unit, factor) = shown(figure, unit);
        let mut values: Vec<f64> =
            known(plan, rows, figure).iter().map(|(value, _)| factor * value).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        let at = |k: usize| {
            let index = last * k / STEPS;
            (values[index], 100.0 * (index + 1) as f64 / rows.len() as f64)
        };
        let points = if values.is_empty() { Vec::new() } else { (0..=STEPS).map(at).collect() };
        charts.push(Chart {
            title: name,
            x: Axis::linear(unit),
            y: Axis::linear("flights up to the value (%)").over(0.0, 100.0),
            curves: vec![Curve { key: 0, points }],
        });
    }
    let caption = "Cumulative distribution: the share of flights whose figure is at most the value on the axis. A \
         steep curve means similar flights, a long tail to the right a few that are much worse than the rest.";
    let figure =
        Figure { name: "distributions".into(), caption: caption.into(), keys: vec![Key::nth(0, "")], charts };
    let parts = vec![Part::Table(table), Part::Figure(figure)];
    Section::new("figures", "Distributions of the figures", parts)
}

fn pushed(plan: &Plan<'_>, rows: &[Row], spreads: &[Spread]) -> Section {
    let names = plan.drawn();
    let mut charts = Vec::new();
    let mut table = Table::new(["figure", "correlated with (rank correlation)"]);
    for Spread { figure, unit, pushed_by, .. } in varied(spreads) {
        let (name, unit, factor) = shown(figure, unit);
        let strong: Vec<&(String, f64)> = pushed_by.iter().filter(|(_, r)| r.abs() >= STRONG).collect();
        let correlations: Vec<String> = strong.iter().map(|(by, r)| format!("{by} {r:+.2}")).collect();
        table.rows.push(vec![
            name.clone(),
            if correlations.is_empty() { "nothing".into() } else { correlations.join(", ") },
        ]);
        let by = strong.first().and_then(|(by, _)| names.iter().position(|(name, _)| name == by));
        if let Some(index) = by {
            let of = &names[index];
            let point = |(value, row): &(f64, &Row)| (row.drawn[index], factor * value);
            let points = known(plan, rows, figure).iter().take(DRAWN).map(point).collect();
            charts.push(Chart {
                title: name,
                x: Axis::linear(if of.1 == "1" { of.0.clone() } else { format!("{} ({})", of.0, of.1) }),
                y: Axis::linear(unit),
                curves: vec![Curve { key: 0, points }],
            });
        }
    }
    let mut parts = vec![
        Part::Text(format!(
            "Rank correlations (Spearman) of at least {STRONG} between random numbers and figures: +1 if one always \
                 increases with the other."
        )),
        Part::Table(table),
    ];
    if !charts.is_empty() {
        let caption = format!(
            "Each figure over the random number with the largest correlation; one point per flight, for the first \
                 {DRAWN} flights with this figure."
        );
        let keys = vec![Key::nth(0, "").dotted()];
        parts.push(Part::Figure(Figure { name: "pushed".into(), caption, keys, charts }));
    }
    Section::new("pushed", "Correlations of the figures", parts)
}

const _: () = assert!(QUANTILES.len() == 3, "the table's head names three");
