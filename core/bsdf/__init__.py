"""How surfaces scatter light: one file per model, one dispatch over them."""
