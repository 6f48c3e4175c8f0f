"""What reproduces the publication: its tables, figures and patterns."""
