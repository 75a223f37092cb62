mod along;
