mod discriminating_experiment;
mod everywhere;
mod few_readings;
mod small_effects;
mod still;
mod trend;
mod words;
