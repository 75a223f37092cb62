mod bought;
