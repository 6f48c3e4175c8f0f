"""What a person chose, what is computed from it, and how one follows the other. Pure."""
