"""What benches are built from: clients, plots and judgements that are tested apart from the measurement."""
