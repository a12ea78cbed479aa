"""Conservation laws in closed form, and the size that follows from them."""
