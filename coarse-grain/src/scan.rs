//! Fields at many widths of the kernel: where they do not depend on it, between the size of a particle and the size of the flow, they
//! are fields (Goldhirsch 2010; Weinhart et al., *Granular Matter* 14, 289, 2012).

use std::path::Path;

use mercury_common::formats::number::{NumberStyle, push_number};

use crate::CgError;
use crate::analysis::{Analysis, TimeMode};
use crate::input::States;
use crate::output::csv;

/// Writes one table with the mean fields at each width: the width first, then coordinates and fields. The input is read once for each
/// width; returns the number of frames and what is wrong with the rest of them.
///
/// # Errors
/// Those of the input; when there is no frame or the file cannot be written.
pub fn write<'a>(
    analysis: &Analysis,
    widths: &[f64],
    states: impl Fn() -> States<'a>,
    path: &Path,
) -> Result<(usize, Option<CgError>), CgError> {
    let mut out = Vec::new();
    let mut told = (0, None);
    for (k, &width) in widths.iter().enumerate() {
        let mut analysis = Analysis {
            time: TimeMode::Average,
            running: false,
            ..analysis.clone()
        };
        analysis.evaluator.kernel.width = width;
        told = analysis.run(states(), |block| {
            if k == 0 {
                let heading = csv::header(&analysis.evaluator, &block, false);
                let (units, names) = heading.split_once('\n').unwrap_or_default();
                let units = units.strip_prefix("# units: ").unwrap_or(units);
                out.extend(format!("# units: m,{units}\nwidth,{names}").into_bytes());
            }
            let mut rows = Vec::new();
            csv::push_rows(&mut rows, &analysis.evaluator, &block, false);
            for row in rows.split_inclusive(|&byte| byte == b'\n') {
                push_number(&mut out, width, NumberStyle::Shortest);
                out.push(b',');
                out.extend_from_slice(row);
            }
            Ok(())
        })?;
        if told.0 == 0 {
            return Err(told.1.unwrap_or_else(|| {
                CgError::Input("no frame is selected, or the input has none".to_owned())
            }));
        }
    }
    std::fs::write(path, out).map_err(|source| CgError::File {
        path: path.to_owned(),
        action: "the file cannot be written",
        source,
    })?;
    Ok(told)
}
