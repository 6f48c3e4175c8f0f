"""The commands `rnnpb` (one module for each of its commands) and `rnnpb-explorer`."""
