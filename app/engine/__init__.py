"""Computes for all pages."""
