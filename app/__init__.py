"""The viser app: one session per browser."""
