//! How a run uses a cluster. Nothing here changes a result.

use serde::{Deserialize, Serialize};

/// What is asked of the scheduler, and how the run follows it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Options {
    /// Shards of an array; nothing = four a slot, as far as blocks and limits allow.
    pub shards: Option<usize>,
    /// Most tasks of an array that run at a time.
    pub max_running: Option<usize>,
    /// Threads of a shard.
    pub cpus_per_task: usize,
    /// Memory of a thread, as the scheduler writes it.
    pub mem_per_cpu: String,
    /// Longest time of a shard, as the scheduler writes it.
    pub time: String,
    /// Partition or queue.
    pub partition: Option<String>,
    /// Account.
    pub account: Option<String>,
    /// Quality of service.
    pub qos: Option<String>,
    /// Features of nodes.
    pub constraint: Option<String>,
    /// Nodes that are not used.
    pub exclude: Vec<String>,
    /// Seconds after which a run no longer waits for tasks whose reason to wait will not pass alone.
    pub pending_timeout_s: Option<u64>,
    /// Seconds before a block that failed is submitted again; doubled each time.
    pub retry_delay_s: u64,
    /// Longest time between two looks at the scheduler, seconds.
    pub poll_s: u64,
    /// Whether a job of the cluster goes on when an array has ended.
    pub finish_on_cluster: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            shards: None,
            max_running: None,
            cpus_per_task: 1,
            mem_per_cpu: "2G".to_owned(),
            time: "01:00:00".to_owned(),
            partition: None,
            account: None,
            qos: None,
            constraint: None,
            exclude: Vec::new(),
            pending_timeout_s: None,
            retry_delay_s: 30,
            poll_s: 30,
            finish_on_cluster: false,
        }
    }
}
