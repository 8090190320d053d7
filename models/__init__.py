"""Vehicles and docks: one folder each, found by their name."""
