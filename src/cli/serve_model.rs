//! `bmv serve-model`.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;

use super::output::{escaped, folded, print, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch;
use crate::batch::served::{NAME, Served};
use crate::job::steady_model::{Entry, SteadyModel};
use crate::runner::http;

/// The protocol's customary port.
const PORT: u16 = 4242;

/// Arguments of `bmv serve-model`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Clients of UM-Bridge in Python, Julia, R and other languages ask the model `forward`: its steady state. The first \
                  vector of `input` has the parameters, the second the inputs where the model has some; the output has the \
                  quantities, those over time left out. All numbers are in SI units; their order is printed. Gradient and \
                  ApplyJacobian are exact. Ctrl-C ends it."
)]
pub(super) struct ServeModel {
    /// Pass file
    pass: PathBuf,
    /// Address to listen at [default: 127.0.0.1]
    #[arg(long, value_name = "IP")]
    address: Option<IpAddr>,
    /// Port; 0 takes a free one [default: 4242]
    #[arg(long, value_name = "N")]
    port: Option<u16>,
    /// Let other machines ask, at an address that they reach
    #[arg(long)]
    allow_remote: bool,
}

impl ServeModel {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        select::one_pass(&self.pass)?;
        let address = self.address.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
        if !address.is_loopback() && !self.allow_remote {
            return Err(Failure::input(format!(
                "other machines reach {address}, and whoever asks is answered: add --allow-remote if that is wanted"
            )));
        }
        let loaded = batch::load(std::slice::from_ref(&self.pass), &context.reading)?;
        let Some(pass) = loaded.passes.first() else { return Ok(Status::WrongInput) };
        let model = SteadyModel::new(&pass.pass.model)
            .map_err(|error| Failure::input(format!("{}: {error}", escaped(&pass.shown))))?;
        let cannot = |error: std::io::Error| Failure::job(format!("cannot listen at {address}: {error}"));
        let listener = TcpListener::bind(SocketAddr::new(address, self.port.unwrap_or(PORT))).map_err(cannot)?;
        for (place, entries) in model.inputs().iter().enumerate() {
            tell(&described(&format!("input[{place}]"), entries, context));
        }
        tell(&described("output[0]", model.outputs(), context));
        // Whoever starts it from a program reads where it listens.
        print(&format!("{NAME} at http://{}\n", listener.local_addr().map_err(cannot)?))?;
        http::serve(&listener, &Served { model }).map_err(cannot)?;
        Ok(Status::Done)
    }
}

/// A number that was written in another unit, to the 15 digits that every conversion keeps: 123.15, not 123.14999999999998.
pub fn in_si(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// The entries of a vector, in a line.
fn described(vector: &str, entries: &[Entry], context: &Context) -> String {
    let entry = |entry: &Entry| {
        let value = entry.nominal.map_or_else(String::new, |nominal| format!(" = {}", in_si(nominal)));
        let unit = if entry.unit == "1" { String::new() } else { format!(" [{}]", entry.unit) };
        format!("{}{unit}{value}", escaped(&entry.name))
    };
    let list: Vec<String> = entries.iter().map(entry).collect();
    folded(&format!("{vector}: "), &list.join(", "), context.fold).trim_end().to_owned()
}
