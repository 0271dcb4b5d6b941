//! Violation of every rule, and order of the elements in the XML.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use squid_model_description::*;

fn variable(name: &str, value_reference: u32, causality: Causality, kind: Kind) -> ScalarVariable {
    let real = matches!(kind, Kind::Real { .. });
    ScalarVariable {
        name: name.to_owned(),
        value_reference,
        description: format!("the {name}"),
        causality,
        variability: match (causality, real) {
            (Causality::Parameter | Causality::CalculatedParameter, _) => Variability::Fixed,
            (_, true) => Variability::Continuous,
            (_, false) => Variability::Discrete,
        },
        initial: None,
        kind,
        derivative_of: None,
        depends_on: None,
        initially_depends_on: None,
    }
}

fn real(start: Option<f64>) -> Kind {
    Kind::Real { unit: None, display_unit: None, min: None, max: None, nominal: None, start }
}

fn on(name: &str) -> Dependency {
    Dependency { on: name.to_owned(), kind: DependencyKind::Dependent }
}

fn description() -> ModelDescription {
    let angle = Kind::Real {
        unit: Some("rad".to_owned()),
        display_unit: Some("deg".to_owned()),
        min: Some(-1.0),
        max: Some(1.0),
        nominal: Some(0.1),
        start: Some(0.25),
    };
    let mut output = variable("plant.y", 7, Causality::Output, real(None));
    output.depends_on = Some(vec![on("x"), on("u")]);
    output.initially_depends_on = Some(vec![]);
    let mut rate = variable("der(x)", 11, Causality::Local, real(None));
    rate.derivative_of = Some("x".to_owned());
    rate.depends_on = Some(vec![Dependency { on: "x".to_owned(), kind: DependencyKind::Constant }]);
    rate.initially_depends_on = Some(vec![on("label")]);
    ModelDescription {
        model_name: "A <model> & \"more\"".to_owned(),
        model_identifier: "a_model".to_owned(),
        description: "For tests".to_owned(),
        author: "Nobody".to_owned(),
        version: "1".to_owned(),
        copyright: "Copyright nobody".to_owned(),
        license: "MIT".to_owned(),
        generation_tool: "test".to_owned(),
        model_exchange: true,
        capabilities: Capabilities::default(),
        co_simulation: CoSimulation::default(),
        enumerations: vec![Enumeration::new(
            "Fidelity",
            "how exact",
            &[("fine", "slow"), ("coarse", "fast")],
        )],
        log_categories: vec![LogCategory { name: "logAll".to_owned(), description: "all".to_owned() }],
        default_experiment: DefaultExperiment {
            start_time: 0.0,
            stop_time: 10.0,
            step_size: 0.01,
            tolerance: Some(1e-6),
        },
        variables: vec![
            variable("u", 0, Causality::Input, angle),
            variable(
                "fidelity",
                1,
                Causality::Parameter,
                Kind::Enumeration { declared_type: "Fidelity".to_owned(), start: Some(2) },
            ),
            variable(
                "n",
                2,
                Causality::Parameter,
                Kind::Integer { min: Some(0), max: Some(9), start: Some(3) },
            ),
            variable("on", 3, Causality::Input, Kind::Boolean { start: Some(true) }),
            variable("label", 4, Causality::Parameter, Kind::String { start: Some("<x>".to_owned()) }),
            output,
            variable("mass", 9, Causality::CalculatedParameter, real(None)),
            variable("x", 10, Causality::Local, real(None)),
            rate,
        ],
    }
}

#[test]
fn valid_description_has_no_problem() {
    assert_eq!(description().check(), []);
}

/// Changes the description and asserts that this is the only problem, and that nothing is written.
#[track_caller]
fn assert_problem(change: impl FnOnce(&mut ModelDescription), expected: &str) {
    let mut description = description();
    change(&mut description);
    let problems: Vec<String> = description.check().iter().map(ToString::to_string).collect();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].contains(expected), "{problems:?}");
    assert!(description.to_xml("", Interfaces::All).unwrap_err().to_string().contains(expected));
}

#[test]
fn finds_problems_of_names_and_roles() {
    assert_problem(|d| d.model_identifier = "a-model".to_owned(), "'a-model' is not a C identifier");
    let word = "'u' holds the character U+0001, which XML cannot";
    assert_problem(|d| d.variables[0].description = "in\u{1}put".to_owned(), word);
    assert_problem(|d| d.description = "\u{ffff}".to_owned(), "holds the character U+FFFF");
    assert_problem(|d| d.variables[3].name = "u".to_owned(), "two variables are called 'u'");
    assert_problem(|d| d.variables[3].name = "a b".to_owned(), "\"a b\" is not made of identifiers");
    assert_problem(|d| d.variables[3].value_reference = 2, "'on' has value reference 2");
    assert_problem(|d| d.variables[0].variability = Variability::Fixed, "'u': causality");
    assert_problem(|d| d.variables[3].variability = Variability::Continuous, "'on': causality");
    assert_problem(|d| d.variables[0].initial = Some(Initial::Exact), "'u': causality");
    assert_problem(|d| d.variables[5].initial = Some(Initial::Exact), "'plant.y' needs a start value");
    assert_problem(|d| d.variables[3].kind = Kind::Boolean { start: None }, "'on' needs a start value");
    assert_problem(|d| d.variables[5].kind = real(Some(0.0)), "'plant.y' is calculated");
    assert_problem(|d| d.variables[5].depends_on = Some(vec![on("v")]), "'plant.y' depends on 'v'");
    assert_problem(|d| d.variables[5].depends_on = Some(vec![on("u"), on("u")]), "depends on 'u'");
}

#[test]
fn finds_problems_of_values() {
    let angle = |min, max, nominal, start| Kind::Real {
        unit: None,
        display_unit: None,
        min: Some(min),
        max: Some(max),
        nominal: Some(nominal),
        start: Some(start),
    };
    assert_problem(|d| d.variables[0].kind = angle(1.0, -1.0, 1.0, 0.0), "min 1 above max -1");
    assert_problem(|d| d.variables[0].kind = angle(-1.0, 1.0, 1.0, 1.5), "starts at 1.5, outside -1 .. 1");
    assert_problem(|d| d.variables[0].kind = angle(-1.0, 1.0, 0.0, 0.0), "nominal 0");
    assert_problem(|d| d.variables[0].kind = real(Some(f64::NAN)), "start = NaN");
    assert_problem(
        |d| d.variables[2].kind = Kind::Integer { min: Some(4), max: None, start: Some(3) },
        "'n' starts at 3",
    );
}

#[test]
fn finds_problems_of_units_types_and_experiment() {
    fn set(d: &mut ModelDescription, new: &str, new_display: Option<&str>) {
        if let Kind::Real { unit, display_unit, .. } = &mut d.variables[0].kind {
            *unit = Some(new.to_owned());
            *display_unit = new_display.map(str::to_owned);
        }
    }
    assert_problem(|d| set(d, "knot", None), "unknown symbol 'knot'");
    assert_problem(|d| set(d, "rad", Some("rpm")), "display unit 'rpm'");
    assert_problem(|d| set(d, "m", Some("deg")), "display unit 'deg'");
    assert_problem(|d| d.enumerations.clear(), "'fidelity' is of type 'Fidelity', which is not defined");
    assert_problem(|d| d.enumerations[0].items.truncate(1), "'fidelity' starts at 2, outside 1 .. 1");
    assert_problem(|d| d.enumerations[0].items[1].name = "fine".to_owned(), "repeats one");
    assert_problem(|d| d.variables[3].name = "Fidelity".to_owned(), "called like a variable");
    assert_problem(|d| d.default_experiment.stop_time = 0.0, "from 0 s to 0 s");
    assert_problem(|d| d.default_experiment.step_size = -1.0, "steps of -1 s");
    assert_problem(|d| d.default_experiment.tolerance = Some(f64::NAN), "cannot be run");
}

#[test]
fn structure_follows_from_variables() {
    let structure = description().structure();
    let kind = DependencyKind::Dependent;
    let output = Unknown { index: 6, dependencies: Some(vec![(1, kind), (8, kind)]) };
    assert_eq!(structure.outputs, [output]);
    let rate = Unknown { index: 9, dependencies: Some(vec![(8, DependencyKind::Constant)]) };
    assert_eq!(structure.derivatives, [rate]);
    let unknown = |index, dependencies| Unknown { index, dependencies };
    let first =
        [unknown(6, Some(vec![])), unknown(7, None), unknown(8, None), unknown(9, Some(vec![(5, kind)]))];
    assert_eq!(structure.initial_unknowns, first);
}

#[test]
fn finds_problems_of_states_and_dependencies() {
    let rate = 8;
    let mut other = description();
    other.variables[rate].derivative_of = Some("on".to_owned());
    let problems: Vec<String> = other.check().iter().map(ToString::to_string).collect();
    assert!(
        problems.contains(&"variable 'der(x)' cannot be the derivative of 'on'".to_owned()),
        "{problems:?}"
    );
    assert_problem(|d| d.variables[rate].name = "der(a b)".to_owned(), "\"der(a b)\" is not made of");
    assert_problem(|d| d.variables[5].depends_on = Some(vec![on("n")]), "'plant.y' cannot depend on 'n'");
    assert_problem(
        |d| d.variables[5].initially_depends_on = Some(vec![on("x")]),
        "cannot depend on 'x' in this way in InitialUnknowns",
    );
    let mut twice = description();
    let mut second = twice.variables[rate].clone();
    (second.name, second.value_reference) = ("der(y)".to_owned(), 12);
    twice.variables.push(second);
    assert_eq!(twice.check().len(), 2, "both claim to be the derivative of x");
    let mut without = description();
    without.model_exchange = false;
    assert_eq!(without.check().len(), 1, "states are for model exchange");
}

#[test]
fn elements_are_in_schema_order() {
    let xml = description().to_xml("{guid}", Interfaces::All).unwrap();
    let mut position = 0;
    for part in [
        r#"<?xml version="1.0" encoding="UTF-8"?>"#,
        r#"<fmiModelDescription fmiVersion="2.0" modelName="A &lt;model&gt; &amp; &quot;more&quot;" guid="{guid}""#,
        r#"numberOfEventIndicators="0">"#,
        r#"<ModelExchange modelIdentifier="a_model""#,
        r#"<CoSimulation modelIdentifier="a_model""#,
        "<UnitDefinitions>",
        r#"<Unit name="rad">"#,
        r#"<BaseUnit rad="1"/>"#,
        r#"<DisplayUnit name="deg" factor="57.29577951308232"/>"#,
        "<TypeDefinitions>",
        r#"<SimpleType name="SI.Angle" description="angle">"#,
        r#"<Real quantity="Angle" unit="rad" displayUnit="deg"/>"#,
        r#"<SimpleType name="Fidelity" description="how exact">"#,
        r#"<Item name="coarse" value="2" description="fast"/>"#,
        "<LogCategories>",
        r#"<DefaultExperiment startTime="0.0" stopTime="10.0" tolerance="1e-6" stepSize="0.01"/>"#,
        "<ModelVariables>",
        concat!(
            r#"<ScalarVariable name="u" valueReference="0" description="the u" causality="input""#,
            r#" variability="continuous">"#
        ),
        concat!(
            r#"<Real declaredType="SI.Angle" unit="rad" displayUnit="deg" min="-1.0" max="1.0""#,
            r#" nominal="0.1" start="0.25"/>"#
        ),
        r#"<Enumeration declaredType="Fidelity" start="2"/>"#,
        r#"<Integer min="0" max="9" start="3"/>"#,
        r#"<Boolean start="true"/>"#,
        r#"<String start="&lt;x&gt;"/>"#,
        r#"causality="output" variability="continuous" initial="calculated">"#,
        r#"<Real derivative="8"/>"#,
        "<ModelStructure>",
        "<Outputs>",
        r#"<Unknown index="6" dependencies="1 8" dependenciesKind="dependent dependent"/>"#,
        "<Derivatives>",
        r#"<Unknown index="9" dependencies="8" dependenciesKind="constant"/>"#,
        "<InitialUnknowns>",
        r#"<Unknown index="6" dependencies="" dependenciesKind=""/>"#,
        r#"<Unknown index="7"/>"#,
        "</fmiModelDescription>\n",
    ] {
        let found = xml[position..].find(part);
        position += found.unwrap_or_else(|| panic!("{part} is not after byte {position} of\n{xml}"));
    }
    assert_eq!(description().to_xml("{guid}", Interfaces::All).unwrap(), xml);
}
