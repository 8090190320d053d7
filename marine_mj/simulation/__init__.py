"""Episodes: runner and log."""
