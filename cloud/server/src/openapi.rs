//! The description of the API, from the types and the paths themselves.

use serde_json::{Value, json};
use utoipa::OpenApi;

use crate::{accounts, audit, downloads, hooks, projects, routes, verify};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Mercury Cloud",
        description = "Submit, watch, stop, resume and fetch runs of mercury-solve."
    ),
    paths(
        routes::check_scene,
        routes::preview_scene,
        routes::runs_list,
        routes::runs_submit,
        routes::run_get,
        routes::run_patch,
        routes::run_delete,
        routes::run_stop,
        routes::run_kill,
        routes::run_resume,
        routes::run_extend,
        routes::run_clone,
        routes::run_branch,
        verify::verification_get,
        verify::verification_begin,
        routes::run_share,
        routes::run_attempts,
        routes::run_events,
        routes::run_log,
        routes::run_tables,
        routes::run_charts,
        routes::run_frames,
        routes::run_frame,
        routes::run_grain,
        routes::run_walls,
        downloads::run_files,
        downloads::run_file,
        downloads::run_archive,
        routes::input_put,
        routes::input_list,
        routes::input_remove,
        routes::study_check,
        routes::study_submit,
        routes::study_list,
        routes::study_table,
        routes::study_csv,
        routes::study_means,
        routes::study_differences,
        projects::project_list,
        projects::project_add,
        projects::project_remove,
        projects::member_set,
        projects::member_remove,
        routes::template_list,
        routes::scene_schema,
        routes::events,
        accounts::session_get,
        accounts::session_begin,
        accounts::session_end,
        accounts::user_list,
        accounts::user_set,
        accounts::user_remove,
        accounts::session_list,
        accounts::session_remove,
        accounts::session_remove_all,
        accounts::share_list,
        accounts::share_remove,
        accounts::run_shares,
        accounts::link_add,
        accounts::token_list,
        accounts::token_add,
        accounts::token_remove,
        hooks::hook_get,
        hooks::hook_set,
        hooks::hook_remove,
        hooks::hook_test,
        audit::audit_list,
    ),
    components(schemas(cloud_api::Problem))
)]
struct Api;

/// The description, as JSON.
pub fn document() -> Value {
    let mut api = serde_json::to_value(Api::openapi()).unwrap_or_default();
    complete(&mut api);
    api
}

/// Whether a path and method has something.
type Has = fn(&Operation) -> bool;

/// Answers that are errors: status, meaning, and where they come.
const ERRORS: [(u16, &str, Has); 14] = [
    (400, "the request is not understood", |_| true),
    (401, "no secret, or one that is good no more", |_| true),
    (
        403,
        "not allowed: by the right of the user, a limit, or the page that sends it",
        |_| true,
    ),
    (404, "not there, or not visible", |of| {
        of.has_path || of.path.contains("/hook")
    }),
    (408, "the body is too slow", |of| of.has_body),
    (
        409,
        "the state does not fit, or another request was faster",
        |of| of.changes,
    ),
    (413, "the body is too long", |of| of.has_body),
    (415, "the body is no JSON", |of| of.has_body),
    (416, "no such bytes", |of| {
        of.path.contains("/files/") || of.path.ends_with("/archive")
    }),
    (421, "for another host", |_| true),
    (422, "the scene cannot run", |of| of.has_body),
    (429, "too many at once; `Retry-After` says when", |_| true),
    (500, "the server failed", |_| true),
    (503, "the store does not respond", |_| true),
];

/// Facts of a path and method that decide which errors it has.
struct Operation<'a> {
    path: &'a str,
    has_path: bool,
    has_body: bool,
    changes: bool,
}

/// Adds what all paths have in common: how requests show their rights, and the answers that are errors.
fn complete(api: &mut Value) {
    api["components"]["securitySchemes"] = json!({
        "token": {"type": "http", "scheme": "bearer", "description": "A token, from `mercury-cloud token NAME`."},
        "session": {"type": "apiKey", "in": "cookie", "name": "mercury-PORT",
            "description": "The cookie of POST /session; behind a proxy with TLS it is called `__Host-mercury`."},
    });
    api["security"] = json!([{"token": []}, {"session": []}]);
    for (path, methods) in api["paths"].as_object_mut().into_iter().flatten() {
        for (method, of) in methods.as_object_mut().into_iter().flatten() {
            let operation = Operation {
                path,
                has_path: path.contains('{') || of["parameters"].is_array(),
                has_body: of["requestBody"].is_object(),
                changes: method != "get",
            };
            if path == "/api/v1/session" && method == "post" {
                // It is the way to get one.
                of["security"] = json!([]);
            }
            let errors = ERRORS.iter().filter(|(.., has)| has(&operation));
            let errors: Vec<(String, Value)> = errors
                .map(|(status, meaning, _)| (status.to_string(), problem(meaning)))
                .collect();
            let Some(answers) = of["responses"].as_object_mut() else {
                continue;
            };
            for (status, answer) in answers.iter_mut() {
                if !answer["description"].is_string() {
                    answer["description"] = json!(match status.as_str() {
                        "201" => "Made",
                        "204" => "Done",
                        "206" => "A part",
                        _ => "The answer",
                    });
                }
            }
            for (status, answer) in errors {
                answers.entry(status).or_insert(answer);
            }
        }
    }
}

/// An answer that is an error.
fn problem(meaning: &str) -> Value {
    let schema = json!({"$ref": "#/components/schemas/Problem"});
    json!({"description": meaning, "content": {"application/problem+json": {"schema": schema}}})
}

/// The page of the documentation that lists the API, made from its description.
#[cfg(test)]
fn page(api: &Value) -> String {
    fn words(value: &Value) -> &str {
        value.as_str().unwrap_or_default()
    }
    fn kind(schema: &Value) -> String {
        if let Some(name) = words(&schema["$ref"])
            .rsplit('/')
            .next()
            .filter(|name| !name.is_empty())
        {
            return format!("[{name}](#{})", name.to_lowercase());
        }
        let parts = ["oneOf", "anyOf", "allOf"]
            .into_iter()
            .find_map(|name| schema[name].as_array());
        if let Some(parts) = parts {
            let parts: Vec<String> = parts
                .iter()
                .filter(|part| part["type"] != "null")
                .map(kind)
                .collect();
            return parts.join(" or ");
        }
        if schema["type"] == "array" {
            return format!("list of {}", kind(&schema["items"]));
        }
        if let Some(values) = schema["enum"].as_array() {
            let values: Vec<String> = values
                .iter()
                .map(|value| format!("`{}`", words(value)))
                .collect();
            return values.join(", ");
        }
        if schema["additionalProperties"].is_object() {
            return format!("name to {}", kind(&schema["additionalProperties"]));
        }
        let of = |name: &Value| words(name).to_owned();
        match &schema["type"] {
            Value::Array(names) => names
                .iter()
                .map(of)
                .filter(|name| name != "null")
                .collect::<Vec<_>>()
                .join(" or "),
            name => of(name),
        }
    }
    fn plain(text: &str) -> String {
        text.replace('\n', " ").replace('|', "\\|")
    }
    let mut text = String::from(
        "# The API of Mercury Cloud\n\n\
         This page is made from the server's own description, `/api/v1/openapi.json`, which `mercury-cloud openapi` prints.\n\n\
         Errors are `application/problem+json`: [Problem](#problem). What is not there, or not yours, is a 404. Lists have 200 entries at\n\
         most, and `after` for the next page. A program sends `Authorization: Bearer mc_...`, with a token from `mercury-cloud token NAME`:\n\n\
         ```sh\ncurl -H \"Authorization: Bearer $TOKEN\" http://127.0.0.1:8080/api/v1/runs?state=running\n```\n\n\
         A browser has a cookie; its requests that change something need `Sec-Fetch-Site: same-origin` or the `Origin` of the server.\n\n\
         ## Paths\n\n| | | body | answer |\n|---|---|---|---|\n",
    );
    for (path, methods) in api["paths"].as_object().into_iter().flatten() {
        for (method, of) in methods.as_object().into_iter().flatten() {
            let content = |place: &Value| -> String {
                let (mime, content) = match place["content"]
                    .as_object()
                    .and_then(|all| all.iter().next())
                {
                    Some((mime, content)) => (mime.as_str(), content),
                    None => return String::new(),
                };
                let schema = kind(&content["schema"]);
                if mime == "application/json" {
                    schema
                } else {
                    mime.to_owned()
                }
            };
            let answer = of["responses"]
                .as_object()
                .and_then(|all| all.iter().find(|(code, _)| code.starts_with('2')));
            let answer = answer.map_or(String::new(), |(code, answer)| {
                format!("{code} {}", content(answer)).trim_end().to_owned()
            });
            let queries: Vec<&str> = (of["parameters"].as_array().into_iter().flatten())
                .filter(|parameter| parameter["in"] == "query")
                .map(|parameter| words(&parameter["name"]))
                .collect();
            let query = if queries.is_empty() {
                String::new()
            } else {
                format!("?{}", queries.join("&"))
            };
            let short = path.strip_prefix("/api/v1").unwrap_or(path);
            let said = [words(&of["summary"]), words(&of["description"])];
            let said = said
                .into_iter()
                .filter(|words| !words.is_empty())
                .collect::<Vec<_>>()
                .join(" ");
            text += &format!(
                "| `{} {short}{query}` | {} | {} | {answer} |\n",
                method.to_uppercase(),
                plain(&said),
                content(&of["requestBody"]),
            );
        }
    }
    text += "\n## A frame\n\n\
        The answer of `GET /runs/{run}/frames/{k}`: the length of the head (u32), the head, and the columns behind each other, each padded\n\
        to 4 bytes; all little-endian. The head is JSON: `time` in s, `step`, `rows` that are here, `of` so many in the frame, and\n\
        `columns` with `name`, `min`, `max`. The first column, which the head does not name, is `id` as u32; then come `x`, `y`, `z`,\n\
        `radius` and the ones in `columns` (names of the frame's columns, or `speed`), each as u16: the value is\n\
        min + (max - min) u / 65535.\n\n\
        ## Bodies\n";
    for (name, schema) in api["components"]["schemas"]
        .as_object()
        .into_iter()
        .flatten()
    {
        text += &format!("\n### {name}\n\n{}\n", words(&schema["description"]));
        if schema["enum"].is_array() {
            text += &format!("\n{}\n", kind(schema));
        }
        let mut fields: Vec<(&String, &Value, bool)> = Vec::new();
        let parts = schema["allOf"]
            .as_array()
            .map_or(vec![schema], |parts| parts.iter().collect());
        for part in parts {
            if part["$ref"].is_string() {
                text += &format!("\nAll of {}, and\n", kind(part));
            }
            let required = part["required"].as_array().cloned().unwrap_or_default();
            for (field, of) in part["properties"].as_object().into_iter().flatten() {
                fields.push((field, of, required.iter().any(|name| name == field)));
            }
        }
        if !fields.is_empty() {
            text += "\n| field | | |\n|---|---|---|\n";
        }
        for (field, of, required) in fields {
            let may = if required { "" } else { ", may be left out" };
            text += &format!(
                "| `{field}` | {}{may} | {} |\n",
                kind(of),
                plain(words(&of["description"]))
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `MERCURY_BLESS=1 cargo test -p cloud-server openapi` writes it anew.
    #[test]
    fn the_page_of_the_api_is_up_to_date() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../docs/formats/cloud-api.md"
        );
        let text = page(&document());
        if std::env::var_os("MERCURY_BLESS").is_some() {
            std::fs::write(path, &text).unwrap();
        }
        let written = std::fs::read_to_string(path).unwrap_or_default();
        assert!(
            text == written,
            "docs/formats/cloud-api.md differs from the API; MERCURY_BLESS=1 writes it anew"
        );
    }

    /// Every path says what it does, and all that it may answer.
    #[test]
    fn every_path_is_described() {
        let api = document();
        for (path, methods) in api["paths"].as_object().unwrap() {
            for (method, of) in methods.as_object().unwrap() {
                assert!(
                    of["summary"].is_string() || of["description"].is_string(),
                    "{method} {path}"
                );
                let answers = of["responses"].as_object().unwrap();
                for (status, answer) in answers {
                    assert!(answer["description"].is_string(), "{method} {path}");
                    let is_problem = answer["content"]["application/problem+json"].is_object();
                    assert_eq!(status >= &"400".to_owned(), is_problem, "{method} {path}");
                }
                for status in ["401", "403", "421", "500"] {
                    assert!(answers.contains_key(status), "{method} {path}: {status}");
                }
            }
        }
    }
}
