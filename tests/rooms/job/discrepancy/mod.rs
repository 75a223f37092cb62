mod residuals;
