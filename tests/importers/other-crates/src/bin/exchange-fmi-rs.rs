//! Integrates an FMU for model exchange with the crate `fmi-rs`, by Euler's method, after it has checked the model
//! description: `exchange-fmi-rs PLAN.json`, which uses the only FMU, step, count, every, record and out of the
//! plan.

use fly_plan::Failure;
use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::model_description::fmi2::ModelDescription;
use fmi_rs::sim::fmi2::me::simulate;
use fmi_rs::sim::fmi2::recorder::Recorder;
use fmi_rs::sim::fmi2::{SimulationSettings, Trajectories};
use fmi_rs::sim::solver::ForwardEulerFactory;
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

fn settings(unzipdir: &Path, description: Arc<ModelDescription>, step: f64, stop: f64) -> SimulationSettings {
    SimulationSettings {
        unzipdir: unzipdir.to_owned(),
        model_description: description,
        start_time: 0.0,
        stop_time: stop,
        logging_on: false,
        set_stop_time: true,
        output_interval: step,
        log_time_scale: false,
        tolerance: 1e-9,
        set_tolerance: false,
        start_values: Vec::new(),
        log_fmi_calls: false,
        input_file: None,
        early_return_allowed: false,
        event_mode_used: false,
        log_file: None,
        initial_fmu_state_file: None,
        final_fmu_state_file: None,
    }
}

fn main() -> Result<(), Failure> {
    let path = std::env::args().nth(1).ok_or("the file of a plan is missing")?;
    let plan: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let number = |key: &str| plan[key].as_f64().ok_or_else(|| Failure::from(format!("a plan has {key}")));
    let text =
        |value: &Value| value.as_str().map(str::to_owned).ok_or_else(|| Failure::from("a text is expected"));
    let fmus = plan["fmus"].as_object().ok_or("a plan names fmus")?;
    let (name, fmu) = fmus.iter().next().ok_or("a plan names an FMU")?;
    let record = plan["record"].as_array().ok_or("a plan names a record")?;
    let record = record.iter().map(text).collect::<Result<Vec<_>, _>>()?;

    let FMU2Builder { unzipdir, model_description, .. } = FMU2Builder::new(&text(fmu)?)?;
    let description = Arc::new(model_description);
    let problems = description.validate();
    if !problems.is_empty() {
        return Err(format!("{problems:?}").into());
    }
    let index = |path: &String| {
        let own = path.strip_prefix(&format!("{name}.")).unwrap_or(path);
        description.modelVariables.iter().position(|one| one.name == own)
    };
    let indices = record.iter().map(index).collect::<Option<Vec<_>>>().ok_or("there is no such variable")?;
    let step = number("step")?;
    let (interval, stop) = (step * number("every")?, step * number("count")?);
    let settings = settings(unzipdir.path(), description.clone(), interval, stop);
    let recorder = Arc::new(Recorder::new(Trajectories::new(description, indices)));
    simulate(&settings, &ForwardEulerFactory { fixed_step_size: step }, None, recorder.clone())?;

    let mut out = std::fs::File::create(text(&plan["out"])?)?;
    writeln!(out, "time,{}", record.join(","))?;
    let flown = recorder.trajectories.borrow();
    for (time, row) in flown.time.iter().zip(&flown.rows) {
        let values = row.iter().map(|value| value.to_f64().map(|value| format!(",{value:?}")));
        let values = values.collect::<Option<String>>().ok_or("a record is of numbers")?;
        writeln!(out, "{time:?}{values}")?;
    }
    Ok(())
}
