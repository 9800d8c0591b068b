"""`strainwave compensate`, `tune` and `order-table`: controllers that cancel the error, gains, and order tables."""
