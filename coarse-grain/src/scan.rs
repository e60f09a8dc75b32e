//! Fields at many widths of the kernel: where they do not depend on it, between the size of a particle and the size of the flow, they
//! are fields (Goldhirsch 2010; Weinhart et al., *Granular Matter* 14, 289, 2012).

use std::path::PathBuf;

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::whole_file::write_whole;

use crate::CgError;
use crate::analysis::{Analysis, TimeMode};
use crate::input::States;
use crate::output::{Format, chart, csv};

/// Writes the mean fields at each width, to each path in the format of its ending: a table (`.csv`) with the width first, then
/// coordinates and fields, or a picture (`.svg`, `.png`) of the fields over the width. The input is read once for each width;
/// returns the number of frames and what is wrong with the rest of them.
///
/// # Errors
/// Errors of the input; when there is no frame, a path has another ending, a picture cannot show so much, or a file cannot be
/// written.
pub fn write<'a>(
    analysis: &Analysis,
    widths: &[f64],
    states: impl Fn() -> States<'a>,
    paths: &[PathBuf],
) -> Result<(usize, Option<CgError>), CgError> {
    let mut is_drawn = false;
    for path in paths {
        match Format::of(path)? {
            Format::Csv => {}
            Format::Svg | Format::Png => is_drawn = true,
            _ => {
                return Err(CgError::Input(format!(
                    "{}: --scan writes a table, .csv, or pictures, .svg and .png",
                    path.display()
                )));
            }
        }
    }
    if is_drawn {
        chart::refuse_widths(&analysis.evaluator, analysis.numbers())?;
    }
    let mut table = Vec::new();
    let mut blocks = Vec::new();
    let mut reported = (0, None);
    for (k, &width) in widths.iter().enumerate() {
        let mut analysis = Analysis {
            time: TimeMode::Average,
            running: false,
            ..analysis.clone()
        };
        analysis.evaluator.kernel.width = width;
        reported = analysis.run(states(), |block| {
            if k == 0 {
                let heading = csv::header(&analysis.evaluator, &block, false);
                let (units, names) = heading.split_once('\n').unwrap_or_default();
                let units = units.strip_prefix("# units: ").unwrap_or(units);
                table.extend(format!("# units: m,{units}\nwidth [m],{names}").into_bytes());
            }
            let mut rows = Vec::new();
            csv::push_rows(&mut rows, &analysis.evaluator, &block, false);
            for row in rows.split_inclusive(|&byte| byte == b'\n') {
                push_number(&mut table, width, NumberStyle::Shortest);
                table.push(b',');
                table.extend_from_slice(row);
            }
            if is_drawn {
                blocks.push((width, block));
            }
            Ok(())
        })?;
        if reported.0 == 0 {
            return Err(reported.1.unwrap_or_else(|| {
                CgError::Input("no frame is selected, or the input has none".to_owned())
            }));
        }
    }
    for path in paths {
        let page = || chart::widths(&analysis.evaluator, &blocks);
        let drawn = match Format::of(path)? {
            Format::Svg => Some(page()?.svg()?.into_bytes()),
            Format::Png => Some(page()?.image()?.png()?),
            _ => None,
        };
        write_whole(path, drawn.as_ref().unwrap_or(&table))?;
    }
    Ok(reported)
}
