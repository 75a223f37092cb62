//! Reports of a folder together: the record that each pass's report leaves of itself, the page over the passes of a study,
//! the page over all studies, the description of a study's reports as a research object. All are pure functions of the
//! records and manifests that lie there, so that they do not depend on which reports a command renders.

mod counterparts;
pub mod index_page;
pub mod record;
pub mod ro_crate;
pub mod study_page;
mod study_tables;
mod timeline;

use std::path::{Path, PathBuf};

use crate::document::hash::sha256_hex;
use crate::runner::Manifest;
use crate::runner::manifest::{FILE_NAME as MANIFEST, FileRecord};
use crate::study::file;

use super::INDEX;

use record::Record;

/// A pass's report as it lies in its folder.
#[derive(Clone, Debug)]
pub struct ArchivedPass {
    /// Name of its folder within the study's.
    pub folder: String,
    /// Its record.
    pub record: Record,
    /// Its manifest.
    pub manifest: Manifest,
    /// Size and hash of the manifest's file.
    pub manifest_file: FileRecord,
}

/// The reports of a study, in the order of the passes' numbers.
#[derive(Clone, Debug)]
pub struct ArchivedStudy {
    /// Name of its folder.
    pub folder: String,
    /// Its passes; never empty.
    pub passes: Vec<ArchivedPass>,
}

impl ArchivedStudy {
    /// The study's document, as its last pass has it.
    pub fn document(&self) -> Option<&crate::study::StudyDocument> {
        self.passes.last().and_then(|pass| pass.record.document.as_ref())
    }

    /// Title of the whole: that of the document, else the study's name.
    pub fn title(&self) -> String {
        self.document().map_or_else(|| self.folder.clone(), |document| document.title.clone())
    }
}

/// A page in both forms.
#[derive(Clone, Debug)]
pub struct RenderedPage {
    /// Markdown.
    pub markdown: String,
    /// HTML.
    pub html: String,
}

impl RenderedPage {
    /// Renders a page. Its figures stand in the HTML; the Markdown has their tables.
    ///
    /// # Errors
    /// As [`super::html::render`].
    pub fn new(page: &super::page::Page) -> Result<Self, super::html::HtmlError> {
        let text = super::page::Page { sections: without_figures(&page.sections), ..page.clone() };
        let marked = |text: String| {
            let text = format!("{}\n", text.trim_end());
            let seal = seal(&text);
            text + &seal
        };
        Ok(Self {
            markdown: marked(super::markdown::render(&text)),
            html: marked(super::html::render(page, super::html::Beside::Nothing)?),
        })
    }
}

/// What stands at the end of every page over reports, by which the program knows its own.
pub const FORMAT: &str = "bmv-index/1";
/// Largest page that is read, bytes.
const LARGEST: u64 = 64 << 20;

/// The last line of a page over reports, with the hash of all above it: it finds what was altered without that.
fn seal(above: &str) -> String {
    format!("<!-- {FORMAT} text={} -->\n", sha256_hex(above.as_bytes()))
}

/// Which pages over reports are not as they were written: in the folder that was named, and in those of the studies whose
/// reports lie below it. A page that is not there, or not the program's own, is none of them.
///
/// # Errors
/// What the system says of a file that is there.
pub fn altered_pages(folder: &Path, reports: &[PathBuf]) -> std::io::Result<Vec<String>> {
    let mut folders: Vec<&Path> = reports.iter().filter_map(|report| report.parent()).collect();
    folders.push(folder);
    folders.sort_unstable();
    folders.dedup();
    let mut altered = Vec::new();
    for place in folders.iter().flat_map(|folder| ["html", "md"].map(|ending| folder.join(format!("{INDEX}.{ending}"))))
    {
        let bytes = match file::read(&place, LARGEST) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error),
        };
        let text = String::from_utf8_lossy(&bytes);
        let end = text.trim_end_matches('\n').rfind('\n').map_or(0, |end| end + 1);
        let (above, own) = text.split_at(end);
        if text.contains(FORMAT) && own != seal(above) {
            altered.push(format!("{} was altered, or written by an earlier version", place.display()));
        }
    }
    Ok(altered)
}

/// Figures have no file of their own beside these pages.
fn without_figures(sections: &[super::page::Section]) -> Vec<super::page::Section> {
    use super::page::Block;
    fn kept(blocks: &[Block]) -> Vec<Block> {
        let one = |block: &Block| match block {
            Block::Figure(_) | Block::Beside(_) => None,
            Block::Details(title, blocks) => {
                let blocks = kept(blocks);
                (!blocks.is_empty()).then(|| Block::Details(title.clone(), blocks))
            }
            other => Some(other.clone()),
        };
        blocks.iter().filter_map(one).collect()
    }
    let sections = sections.iter().map(|own| super::page::Section { blocks: kept(&own.blocks), ..own.clone() });
    sections.filter(|section| !section.blocks.is_empty()).collect()
}

/// The folders of reports at a folder: itself where it is one, else those below it, at most two deep, in order.
pub fn reports_below(folder: &Path) -> Vec<PathBuf> {
    let visible =
        |entry: &walkdir::DirEntry| entry.depth() == 0 || !entry.file_name().to_string_lossy().starts_with('.');
    let walk = walkdir::WalkDir::new(folder).max_depth(3).sort_by_file_name().into_iter().filter_entry(visible);
    let manifests = walk.flatten().filter(|entry| entry.file_type().is_file() && entry.file_name() == MANIFEST);
    let found: Vec<PathBuf> = manifests.filter_map(|entry| entry.path().parent().map(Path::to_owned)).collect();
    if found.iter().any(|own| own == folder) { vec![folder.to_owned()] } else { found }
}

/// A record of this hash is the one that a manifest lists under `record.json`.
pub fn is_listed(manifest: &Manifest, bytes: &[u8]) -> bool {
    let listed = manifest.outputs.get(record::FILE_NAME);
    listed.is_some_and(|listed| listed.sha256.as_str() == sha256_hex(bytes))
}
