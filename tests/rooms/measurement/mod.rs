mod clock;
mod lag;
mod prediction;
mod scatter;
mod timing;
