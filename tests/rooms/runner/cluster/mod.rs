mod shards;
mod slurm;
mod worker;
