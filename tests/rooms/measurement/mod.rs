mod clock;
mod lag;
mod scatter;
