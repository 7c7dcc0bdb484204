"""Run what a model file asks for, and compare variants of a model."""
