"""Sea, current and wind as frozen, seeded realisations."""
