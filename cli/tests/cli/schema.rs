//! What `--json` prints is what `maquette schema` describes.

use serde_json::Value;

use crate::arm::{Arm, run};
use crate::walker::Walker;

/// Where a value is not what a schema says, of the few keywords that our schemas use.
fn faults(value: &Value, schema: &Value, at: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for (keyword, rule) in schema.as_object().expect("a schema") {
        match keyword.as_str() {
            "$schema" | "title" => {}
            "type" if is_of_type(value, rule) => {}
            // a rule for objects
            "required" if value.is_null() => {}
            "enum" if rule.as_array().is_some_and(|all| all.contains(value)) => {}
            "minimum" if value.as_f64().is_none_or(|v| v >= rule.as_f64().expect("a number")) => {}
            "required" => {
                let names = rule.as_array().into_iter().flatten().filter_map(Value::as_str);
                let lacking = names.filter(|name| value.get(name).is_none());
                faults.extend(lacking.map(|name| format!("{at}: no {name}")));
            }
            "properties" => {
                for (name, rule) in rule.as_object().expect("properties") {
                    let inner =
                        value.get(name).map(|v| self::faults(v, rule, &format!("{at}/{name}")));
                    faults.extend(inner.into_iter().flatten());
                }
            }
            "additionalProperties" => {
                let known = schema["properties"].as_object().expect("properties");
                let names = value.as_object().into_iter().flat_map(|object| object.keys());
                let unknown = names.filter(|name| !known.contains_key(*name));
                faults.extend(unknown.map(|name| format!("{at}: {name} is not described")));
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    faults.extend(self::faults(item, rule, &format!("{at}/{i}")));
                }
            }
            _ => faults.push(format!("{at}: {keyword} {rule}: {value}")),
        }
    }
    faults
}

fn is_of_type(value: &Value, rule: &Value) -> bool {
    let is = |name: &Value| match name.as_str() {
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_u64() || value.is_i64(),
        Some("null") => value.is_null(),
        Some("array") => value.is_array(),
        Some("object") => value.is_object(),
        _ => false,
    };
    rule.as_array().map_or_else(|| is(rule), |names| names.iter().any(is))
}

/// Checks what a command printed against its schema.
pub(crate) fn check(verb: &str, printed: &str) -> Value {
    let schema = run(&["schema", verb]).succeeded().out;
    let schema: Value = serde_json::from_str(&schema).expect("a schema");
    let value: Value = serde_json::from_str(printed).expect("JSON");
    let faults = faults(&value, &schema, "");
    assert!(faults.is_empty(), "{verb}: {faults:#?}");
    value
}

#[test]
fn a_schema_is_a_rule() {
    let schema: Value = serde_json::from_str(
        r#"{"type": "object", "required": ["a"], "properties": {"a": {"type": "integer", "minimum": 0}},
            "additionalProperties": false}"#,
    )
    .expect("a schema");
    let found = |text: &str| faults(&serde_json::from_str(text).expect("JSON"), &schema, "").len();
    assert_eq!(found(r#"{"a": 1}"#), 0);
    assert_eq!(
        [r#"{}"#, r#"{"a": -1}"#, r#"{"a": "1"}"#, r#"{"a": 1, "b": 2}"#].map(found),
        [1, 1, 1, 1]
    );
}

#[test]
fn what_a_fit_a_walk_the_models_and_a_synthetic_recording_print_is_described() {
    let arm = Arm::new();
    let fit = check("fit", &arm.fit("out", &["--json", "--quiet"]).succeeded().out);
    assert_eq!(fit["lengths"][0]["name"], "upper");
    let models = check("models", &run(&["models", "--json"]).succeeded().out);
    assert!(models["models"].as_array().is_some_and(|all| all.len() > 4));

    let out = arm.out("synth").display().to_string();
    let synth = ["synth", &out, "--frames", "2", "--cameras", "2", "--json"];
    assert_eq!(check("synth", &run(&synth).succeeded().out)["frames"], 2);

    let trc = arm.out("walk.trc");
    std::fs::write(&trc, Walker::new(0.4).trc()).expect("a file");
    let walk = ["gait", trc.to_str().expect("UTF-8"), "--json"];
    assert_eq!(check("gait", &run(&walk).succeeded().out)["gait"]["format"], "maquette-gait");
    // what stands there is replaced only when that is asked for
    run(&walk).refused(&["not empty", "--overwrite"]);
    run(&[&walk[..], &["--overwrite"]].concat()).succeeded();
}

#[test]
fn shells_and_man_know_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(&["completions", shell]).succeeded().out;
        assert!(script.contains("silhouettes") && script.contains("keyframe-every"), "{shell}");
    }
    let page = run(&["man"]).succeeded().out;
    for part in [".TH maquette 1", "MAQUETTE FIT", "keyframe", "MAQUETTE STEREO"] {
        assert!(page.contains(part), "{part}");
    }
}
