mod information;
