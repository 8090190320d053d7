"""dm_control tasks."""
