mod estimate;
mod like_sensors;
mod model_error;
mod restricted_likelihood;
