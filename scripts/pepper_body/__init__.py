"""How static/pepper is made: joints as published, shapes of our own."""
