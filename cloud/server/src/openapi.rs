//! The description of the API, from the types and the paths themselves.

use utoipa::OpenApi;

use crate::routes;

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
        routes::run_files,
        routes::run_file,
        routes::run_archive,
        routes::input_put,
        routes::study_check,
        routes::study_submit,
        routes::study_list,
        routes::study_table,
        routes::study_csv,
        routes::template_list,
        routes::events,
        routes::session_get,
        routes::session_begin,
        routes::session_end,
        routes::user_list,
        routes::user_set,
        routes::token_list,
        routes::token_add,
        routes::token_remove,
    ),
    components(schemas(cloud_api::Problem))
)]
struct Api;

/// The description, as JSON.
pub fn document() -> serde_json::Value {
    serde_json::to_value(Api::openapi()).unwrap_or_default()
}
