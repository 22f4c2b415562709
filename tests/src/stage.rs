//! Which stage of the tick an instruction belongs to, told by the debug information: no marker in the image.

use addr2line::Loader;

use crate::image::Image;

/// A stage: its name, and parts of the paths of the functions that it consists of.
pub type Stage<'a> = (&'a str, &'a [&'a str]);

/// Stage of every instruction, by its address in order: the innermost function of its inlined call chain that a stage
/// names, `None` where none does (a routine shared by stages belongs to whichever calls it).
pub fn attribute(image: &Image, stages: &[Stage]) -> Result<Vec<(u32, Option<usize>)>, String> {
    let debug = Loader::new(&image.path).map_err(|e| format!("{}: {e}", image.path.display()))?;
    image.code.keys().map(|&at| Ok((at, stage_at(&debug, at, stages)?))).collect()
}

fn stage_at(debug: &Loader, at: u32, stages: &[Stage]) -> Result<Option<usize>, String> {
    let mut found = None;
    let mut frames = debug.find_frames(u64::from(at)).map_err(|e| e.to_string())?;
    while let Some(frame) = frames.next().map_err(|e| e.to_string())? {
        let Some(function) = frame.function else { continue };
        let name = function.demangle().map_err(|e| e.to_string())?;
        let hit = stages.iter().position(|(_, parts)| parts.iter().any(|p| name.contains(p)));
        found = found.or(hit);
    }
    Ok(found)
}
