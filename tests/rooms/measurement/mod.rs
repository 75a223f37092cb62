mod lag;
mod scatter;
