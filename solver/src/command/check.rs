//! `--check`: the meaning of a scene, whether its run fits into the machine, and how long it will take if a trial was requested.

use std::path::PathBuf;

use crate::plan::{Disk, Memory, Plan, document_as_json, files, report, sha256, summed};
use crate::run::check_fit;
use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::machine::MachineMemory;
use mercury_common::readable;
use mercury_common::scene::{Scene, SceneErrors};
use serde_json::{Value, json};

use super::Arguments;
use super::input::{Input, refused};
use super::problems::{self, say_object};
use super::run::disk_warning;
use super::trial;

/// Says it all.
pub(crate) fn execute(
    arguments: &Arguments,
    input: &Input,
    scene: &Scene,
    plan: Plan,
    memory: &Memory,
    machine: Option<MachineMemory>,
    (results, few_rows): (&str, Vec<String>),
) -> Outcome {
    let fits = match machine.filter(|_| !arguments.force_memory) {
        Some(limit) => check_fit(scene, &plan, memory, limit)
            .map_err(|error| refused(&SceneErrors(vec![error]))),
        None => Ok(()),
    };
    let limit = arguments.trial.filter(|_| fits.is_ok());
    let mut object = Value::Null;
    // As text the plan is printed first, so that it can be read during the trial.
    let bytes = Disk::of(&plan).bytes;
    let folder = arguments.how().folder;
    let folder = folder.unwrap_or_else(|| PathBuf::from(plan.outputs().prefix()));
    let warnings: Vec<String> = disk_warning(&folder, bytes)
        .into_iter()
        .chain(few_rows)
        .collect();
    if arguments.json {
        object = as_json(input, scene, &plan, memory)?;
        if let Some(all) = object["warnings"].as_array_mut() {
            all.extend(warnings.into_iter().map(Value::from));
        }
    } else {
        for warning in warnings {
            say(&format!("warning: {warning}\n"))?;
        }
        say(&report(&plan, memory, machine))?;
        if !results.is_empty() {
            say(results)?;
        }
    }
    let trial = match limit {
        Some(limit) => {
            let quiet = arguments.quiet || arguments.json;
            let trial = trial::execute(plan, &arguments.how(), limit, quiet)?;
            Some(trial)
        }
        None => None,
    };
    if arguments.json {
        if let Some(trial) = &trial {
            object["trial"] = serde_json::to_value(trial).map_err(Failure::run)?;
        }
        if let Err(failure) = &fits {
            let found = failure.problems().unwrap_or_default();
            object["problems"] = problems::list(&found);
        }
        say_object(&object)?;
    } else if let Some(trial) = &trial {
        let bytes = readable::bytes(bytes);
        say(&format!("\n{trial}  {:<24}about {bytes}", "on the disk"))?;
    }
    match trial.is_some_and(|trial| trial.is_cut_short) {
        true => Err(trial::ended("before its time").answered()),
        false => fits.map_err(|failure| match arguments.json {
            true => failure.answered(),
            false => failure,
        }),
    }
}

/// The plan, the scene and all files that were read for it.
fn as_json(input: &Input, scene: &Scene, plan: &Plan, memory: &Memory) -> Result<Value, Failure> {
    let mut object = document_as_json(plan, memory)
        .map_err(|error| Failure::run(format!("the plan cannot be written: {error}")))?;
    object["scene"] = json!({
        "name": input.path.display().to_string(),
        "bytes": input.text.len(),
        "sha256": sha256(input.text.as_bytes()),
    });
    let mut all = Vec::new();
    for file in files(scene, plan) {
        let (bytes, sum) = summed(&file.path).map_err(|error| {
            Failure::input(format!(
                "{}: the file cannot be read: {error}",
                file.path.display()
            ))
        })?;
        let mut one = json!({ "key": file.key, "name": file.name, "bytes": bytes, "sha256": sum });
        if let Some(from) = file.from {
            one["from"] = from.into();
        }
        all.push(one);
    }
    object["files"] = all.into();
    Ok(object)
}
