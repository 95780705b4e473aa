"""Where a mechanism is singular: equations of such poses, and curves of them."""
