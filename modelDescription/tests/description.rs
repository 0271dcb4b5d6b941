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

/// Changes the description and returns its only problem; nothing is written then.
#[track_caller]
fn problem(change: impl FnOnce(&mut ModelDescription)) -> Problem {
    let mut description = description();
    change(&mut description);
    let [problem] = description.check().try_into().unwrap();
    assert!(description.to_xml("", Interfaces::All).unwrap_err().to_string().contains(&problem.to_string()));
    problem
}

/// Returns the messages of problems, one a line.
fn messages(problems: &[Problem]) -> String {
    problems.iter().map(|problem| format!("{problem}\n")).collect()
}

fn named(name: &str) -> String {
    name.to_owned()
}

#[test]
fn finds_problems_of_names_and_roles() {
    let found = [
        problem(|d| d.model_identifier = named("a-model")),
        problem(|d| d.variables[0].description = named("in\u{1}put")),
        problem(|d| d.description = named("\u{ffff}")),
        problem(|d| d.variables[3].name = named("u")),
        problem(|d| d.variables[3].name = named("a b")),
        problem(|d| d.variables[3].value_reference = 2),
        problem(|d| d.variables[0].variability = Variability::Fixed),
        problem(|d| d.variables[3].variability = Variability::Continuous),
        problem(|d| d.variables[0].initial = Some(Initial::Exact)),
        problem(|d| d.variables[5].initial = Some(Initial::Exact)),
        problem(|d| d.variables[3].kind = Kind::Boolean { start: None }),
        problem(|d| d.variables[5].kind = real(Some(0.0))),
        problem(|d| d.variables[5].depends_on = Some(vec![on("v")])),
        problem(|d| d.variables[5].depends_on = Some(vec![on("u"), on("u")])),
    ];
    let illegal = |name| Problem::IllegalCombination { name: named(name) };
    let expected = [
        Problem::BadIdentifier { identifier: named("a-model") },
        Problem::BadCharacter { place: named("u"), character: '\u{1}' },
        Problem::BadCharacter { place: named("a_model"), character: '\u{ffff}' },
        Problem::DuplicateName { name: named("u") },
        Problem::BadName { name: named("a b") },
        Problem::DuplicateValueReference { name: named("on"), value_reference: 2 },
        illegal("u"),
        illegal("on"),
        illegal("u"),
        Problem::MissingStart { name: named("plant.y") },
        Problem::MissingStart { name: named("on") },
        Problem::UnexpectedStart { name: named("plant.y") },
        Problem::BadDependency { name: named("plant.y"), on: named("v") },
        Problem::BadDependency { name: named("plant.y"), on: named("u") },
    ];
    assert_eq!(found, expected);
    insta::assert_snapshot!(messages(&found));
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
    let found = [
        problem(|d| d.variables[0].kind = angle(1.0, -1.0, 1.0, 0.0)),
        problem(|d| d.variables[0].kind = angle(-1.0, 1.0, 1.0, 1.5)),
        problem(|d| d.variables[0].kind = angle(-1.0, 1.0, 0.0, 0.0)),
        problem(|d| d.variables[2].kind = Kind::Integer { min: Some(4), max: None, start: Some(3) }),
        problem(|d| d.variables[0].kind = real(Some(f64::NAN))),
    ];
    let u = || named("u");
    let expected = [
        Problem::MinAboveMax { name: u(), min: 1.0, max: -1.0 },
        Problem::StartOutOfRange { name: u(), start: 1.5, min: -1.0, max: 1.0 },
        Problem::NominalNotPositive { name: u(), nominal: 0.0 },
    ];
    assert_eq!(found[..3], expected);
    assert!(
        matches!(&found[3], Problem::StartOutOfRange { name, start: 3.0, min: 4.0, .. } if name == "n"),
        "{:?}",
        found[3]
    );
    assert!(
        matches!(&found[4], Problem::NotFinite { name, attribute: "start", value } if name == "u" && value.is_nan()),
        "{:?}",
        found[4]
    );
    insta::assert_snapshot!(messages(&found));
}

#[test]
fn finds_problems_of_units_types_and_experiment() {
    fn set(d: &mut ModelDescription, new: &str, new_display: Option<&str>) {
        if let Kind::Real { unit, display_unit, .. } = &mut d.variables[0].kind {
            *unit = Some(named(new));
            *display_unit = new_display.map(named);
        }
    }
    let found = [
        problem(|d| set(d, "knot", None)),
        problem(|d| set(d, "rad", Some("rpm"))),
        problem(|d| set(d, "m", Some("deg"))),
        problem(|d| d.enumerations.clear()),
        problem(|d| d.enumerations[0].items.truncate(1)),
        problem(|d| d.enumerations[0].items[1].name = named("fine")),
        problem(|d| d.variables[3].name = named("Fidelity")),
        problem(|d| d.default_experiment.stop_time = 0.0),
        problem(|d| d.default_experiment.step_size = -1.0),
        problem(|d| d.default_experiment.tolerance = Some(f64::NAN)),
    ];
    assert!(matches!(&found[0], Problem::UnknownUnit { name, .. } if name == "u"), "{:?}", found[0]);
    let unknown = |unit| Problem::UnknownDisplayUnit { name: named("u"), display_unit: named(unit) };
    let bad_enumeration = || Problem::BadEnumeration { name: named("Fidelity") };
    let bad_experiment = |stop, step| Problem::BadExperiment { start: 0.0, stop, step };
    let expected = [
        unknown("rpm"),
        unknown("deg"),
        Problem::UnknownType { name: named("fidelity"), declared_type: named("Fidelity") },
        Problem::StartOutOfRange { name: named("fidelity"), start: 2.0, min: 1.0, max: 1.0 },
        bad_enumeration(),
        bad_enumeration(),
        bad_experiment(0.0, 0.01),
        bad_experiment(10.0, -1.0),
        bad_experiment(10.0, 0.01),
    ];
    assert_eq!(found[1..], expected);
    insta::assert_snapshot!(messages(&found));
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
    let wrong = Problem::BadDerivative { name: named("der(x)"), state: named("on") };
    assert!(other.check().contains(&wrong), "{:?}", other.check());
    let no_known = |on, list| Problem::NoKnown { name: named("plant.y"), on: named(on), list };
    let found = [
        wrong,
        problem(|d| d.variables[rate].name = named("der(a b)")),
        problem(|d| d.variables[5].depends_on = Some(vec![on("n")])),
        problem(|d| d.variables[5].initially_depends_on = Some(vec![on("x")])),
    ];
    let expected = [
        Problem::BadName { name: named("der(a b)") },
        no_known("n", "Outputs"),
        no_known("x", "InitialUnknowns"),
    ];
    assert_eq!(found[1..], expected);
    insta::assert_snapshot!(messages(&found));
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
