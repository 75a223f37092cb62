mod answer;
mod score;
