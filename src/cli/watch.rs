//! `bmv watch`.

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;

use super::Context;
use super::execute::run_listened;
use super::options::{CachedRunOptions, RunOptions};
use super::output::{print, shown, tell};
use super::status::{Failure, Status};
use crate::batch::Prepared;
use crate::batch::live::{Followed, Site, State, follow};
use crate::runner::{Cache, Listener, StopFlag, http};
use crate::study::discover;

/// Arguments of `bmv watch`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The link that it prints opens one browser of this machine, once; another one is printed then. The page loads anew \
                  by itself, says what is wrong with a file at its place, and writes the next pass on request, as bmv adopt does. \
                  Reports are kept in memory: bmv report writes them. Ctrl-C ends it.\n\n\
                  Examples:\n  \
                  bmv watch my-study\n  \
                  bmv watch my-study/pass-2.json --port 8080"
)]
pub(super) struct Watch {
    /// Folder of a study, or one of its passes
    #[arg(value_name = "STUDY")]
    path: PathBuf,
    /// Port of 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    #[command(flatten)]
    options: CachedRunOptions,
}

impl Watch {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let studies = discover(std::slice::from_ref(&self.path)).map_err(|error| Failure::input(error.to_string()))?;
        let [study] = studies.as_slice() else {
            let names: Vec<String> = studies.iter().map(|study| shown(&study.folder)).collect();
            let path = shown(&self.path);
            return Err(Failure::input(format!("`{path}` holds several studies; watch one: {}", names.join(", "))));
        };
        let cannot = |error: std::io::Error| Failure::job(format!("cannot listen at 127.0.0.1: {error}"));
        let listener = TcpListener::bind(SocketAddr::new(Ipv4Addr::LOCALHOST.into(), self.port)).map_err(cannot)?;
        let port = listener.local_addr().map_err(cannot)?.port();
        let state = Arc::new(State::default());
        let site = Arc::new(Site::new(Arc::clone(&state), port, Box::new(tell)).map_err(cannot)?);
        // Whoever starts it from a program reads where it is.
        print(&format!("{}\n", site.link()))?;
        http::serve_beside(listener, site).map_err(cannot)?;
        let options = RunOptions::from(self.options);
        let run = |prepared: Prepared, stop: &StopFlag, listener: &dyn Listener| {
            let both = |prepared: Prepared, cache: &Cache, progress: &dyn Listener| {
                prepared.run_until(options.settings(), cache, stop, &vec![progress, listener])
            };
            run_listened(prepared, &options.cache, both)
        };
        let followed = Followed { folder: study.folder.clone(), path: self.path, reading: context.reading.clone() };
        follow(&followed, &state, &run, &tell)
    }
}
