//! What of a report stands before its appendix: in six screens what was found, then all the rest, to be looked up.
//!
//! A section gives to the body what fits its share, in its own order; what is left of it stands in the appendix under the same
//! title. Sections without a share stand there whole. A report that is short enough has no appendix.

mod height;

use super::page::{Block, Section, Text, rest_of};
use height::{HEADER, SECTION, height};

/// Height of the body with what stands above it, pixels at a window of 1280 × 800: six screens, less what estimates may miss.
const MOST: f64 = 4650.0;
/// Less than this is no room for a section.
const LEAST: f64 = 170.0;
/// The line that leads to the rest of a section.
const LEADS_ON: f64 = 39.0;

/// Which sections have a share of the body, most important first, and how large it is at most, pixels. The first takes all that
/// it needs.
const SHARES: &[(&str, f64)] = &[
    ("summary", f64::INFINITY),
    ("compliance", 700.0),
    ("diagnosis", 900.0),
    ("problem", 290.0),
    ("margins", 560.0),
    ("prediction", 520.0),
    ("sizing", 780.0),
    ("calibration", 520.0),
    ("comparison", 640.0),
    ("propagation", 420.0),
    ("history", 500.0),
    ("adopted", 300.0),
    ("sensitivity", 420.0),
    ("goal", 480.0),
    ("discrepancy", 400.0),
    ("design", 420.0),
    ("test-plan", 420.0),
    ("margins-from-history", 360.0),
];

/// The sections before the appendix, and those in it.
pub fn divided(sections: Vec<Section>) -> (Vec<Section>, Vec<Section>) {
    let whole = |section: &Section| SECTION + section.blocks.iter().map(height).sum::<f64>();
    if HEADER + sections.iter().map(whole).sum::<f64>() <= MOST {
        return (sections, Vec::new());
    }
    let mut left = MOST - HEADER;
    // What each section gives: for every block whether it stands in the body.
    let mut given: Vec<Vec<bool>> = sections.iter().map(|section| vec![false; section.blocks.len()]).collect();
    for (id, share) in SHARES {
        let Some(at) = sections.iter().position(|section| section.id == *id) else { continue };
        let room = share.min(if share.is_infinite() { f64::INFINITY } else { left - SECTION });
        if room < LEAST && share.is_finite() {
            continue;
        }
        let (chosen, used) = fitting(&sections[at].blocks, room);
        if chosen.contains(&true) {
            left -= SECTION + used;
            given[at] = chosen;
        }
    }
    let (mut body, mut appendix) = (Vec::new(), Vec::new());
    for (section, chosen) in sections.into_iter().zip(given) {
        let (first, rest) = split(section.blocks, &chosen);
        let with = |blocks: Vec<Block>| Section { id: section.id, title: section.title.clone(), blocks };
        match (first.is_empty(), rest.is_empty()) {
            (true, _) => appendix.push(with(rest)),
            (false, true) => body.push(with(first)),
            (false, false) => {
                let leads_on = Text::default().link_here("Details in the appendix", &rest_of(section.id)).plain(".");
                body.push(with(first.into_iter().chain([Block::Small(leads_on)]).collect()));
                appendix.push(with(rest));
            }
        }
    }
    (body, appendix)
}

/// Which blocks fit into a height, in their order, and how high they are together. Folded ones are details by nature, and a
/// heading stands only above something.
fn fitting(blocks: &[Block], room: f64) -> (Vec<bool>, f64) {
    let whole: f64 = blocks.iter().map(height).sum();
    if whole <= room {
        return (vec![true; blocks.len()], whole);
    }
    let room = room - LEADS_ON;
    let (mut used, mut chosen) = (0.0, vec![false; blocks.len()]);
    // A heading, or a line that announces what follows, stands only above it.
    let mut above: Vec<usize> = Vec::new();
    for (at, block) in blocks.iter().enumerate() {
        match block {
            // What is left out above is not overtaken by what comes under another heading.
            Block::Heading(_) if used > 0.0 => break,
            Block::Heading(_) => above = vec![at],
            _ if announces(block) => above.push(at),
            Block::Details(..) => {}
            _ => {
                let needed = height(block) + above.iter().map(|&own| height(&blocks[own])).sum::<f64>();
                if used + needed <= room {
                    used += needed;
                    above.iter().chain([&at]).for_each(|&own| chosen[own] = true);
                }
                // A heading stays for what comes next; it is counted once.
                above.retain(|&own| !chosen[own] && matches!(blocks[own], Block::Heading(_)));
            }
        }
    }
    (chosen, used + LEADS_ON)
}

/// Whether a paragraph ends with a colon.
fn announces(block: &Block) -> bool {
    matches!(block, Block::Paragraph(text) if text.in_plain_words().trim_end().ends_with(':'))
}

/// The chosen blocks and the others. A heading that is chosen is repeated above what is left below it.
fn split(blocks: Vec<Block>, chosen: &[bool]) -> (Vec<Block>, Vec<Block>) {
    let (mut first, mut rest) = (Vec::new(), Vec::new());
    let mut heading: Option<Block> = None;
    for (block, &is_chosen) in blocks.into_iter().zip(chosen) {
        if matches!(block, Block::Heading(_)) {
            if is_chosen {
                first.push(block.clone());
            }
            heading = Some(block);
        } else if is_chosen {
            first.push(block);
        } else {
            rest.extend(heading.take());
            rest.push(block);
        }
    }
    (first, rest)
}
